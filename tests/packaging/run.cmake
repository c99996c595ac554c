include("${CMAKE_CURRENT_LIST_DIR}/run_commands.cmake")
set(HERE "${CMAKE_CURRENT_LIST_DIR}")
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")

# A project that computes, reads and scores, and a plugin, as anybody would write them.
run("" ${configure} -S "${HERE}/consumer" -B "${WORK}/consumer")
run("" ${CMAKE_COMMAND} --build "${WORK}/consumer")
file(WRITE "${WORK}/boxes.csv" "0,0,0,4,2,2,0\n1,0,0,4,2,2,0\n")
file(WRITE "${WORK}/cloud.csv" "x,y,z\n1,2,3\n4,5,6\n")
run("iou 0.6, points 2, auc 1" "${WORK}/consumer/consumer" "${WORK}/boxes.csv" "${WORK}/cloud.csv")
run("detector nothing, version 1.0.0"
  "${PREFIX}/bin/arbox" plugins check "${WORK}/consumer/libarbox_detector_nothing.so")

# Each component loads only what it needs.
set(without -DCMAKE_DISABLE_FIND_PACKAGE_Torch=ON -DCMAKE_DISABLE_FIND_PACKAGE_PCL=ON
  -DCMAKE_DISABLE_FIND_PACKAGE_OpenCV=ON -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON)
run("targets: base geometry\n" ${configure} ${without} "-DCOMPONENTS=geometry"
  -S "${HERE}/probe" -B "${WORK}/probe_geometry")
run("targets: base\n" ${configure} ${without} -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON
  "-DCOMPONENTS=base" -S "${HERE}/probe" -B "${WORK}/probe_base")
run("arbox_FOUND: 0" ${configure} "-DOPTIONAL=ON" "-DCOMPONENTS=no_such"
  -S "${HERE}/probe" -B "${WORK}/probe_optional")
run("program: ${PREFIX}/bin/arbox" ${configure} "-DCOMPONENTS=program"
  -S "${HERE}/probe" -B "${WORK}/probe_program")

# What cannot be had is refused with the reason.
refused("'geometri' is not a component of Arbox; installed components: base, geometry"
  ${configure} "-DCOMPONENTS=geometri" -S "${HERE}/probe" -B "${WORK}/probe_unknown")
refused("requested version \"99.0\"" ${configure} "-DVERSION=99.0" "-DCOMPONENTS=base"
  -S "${HERE}/probe" -B "${WORK}/probe_version")
file(GLOB package "${PREFIX}/lib*/cmake/arbox" "${PREFIX}/lib*/*/cmake/arbox")
file(COPY ${package} DESTINATION "${WORK}/part/lib/cmake")
file(GLOB files "${WORK}/part/lib/cmake/arbox/arbox-io-targets*")
file(REMOVE ${files})
refused("'io' is not installed; installed components: base, geometry"
  ${configure} "-Darbox_DIR=${WORK}/part/lib/cmake/arbox" "-DCOMPONENTS=io" -S "${HERE}/probe"
  -B "${WORK}/probe_missing")
file(REMOVE_RECURSE "${WORK}")
