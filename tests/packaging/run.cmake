# Variables: BUILD (build folder), WORK (scratch folder), COMPILER, BUILD_TYPE, FLAGS.
get_filename_component(HERE "${CMAKE_CURRENT_LIST_DIR}" ABSOLUTE)
set(PREFIX "${WORK}/prefix")

# run(<expected part of the output> command...): fails the test unless it ends with 0 and says so.
function(run expected)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  string(FIND "${output}" "${expected}" place)
  if(NOT code EQUAL 0 OR place EQUAL -1)
    message(FATAL_ERROR "${ARGN}\nended with ${code}, expected 0 and '${expected}':\n${output}")
  endif()
endfunction()

# refused(<part of the message> command...): fails the test unless it fails and says why.
function(refused expected)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  string(FIND "${output}" "${expected}" place)
  if(code EQUAL 0 OR place EQUAL -1)
    message(FATAL_ERROR "${ARGN}\nended with ${code}, expected a failure with '${expected}':\n${output}")
  endif()
endfunction()

set(configure ${CMAKE_COMMAND} -G Ninja
  "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_BUILD_TYPE=${BUILD_TYPE}" "-DCMAKE_CXX_FLAGS=${FLAGS}"
  "-DCMAKE_PREFIX_PATH=${PREFIX}")

file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
run("" ${CMAKE_COMMAND} --install "${BUILD}" --prefix "${PREFIX}")

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
file(GLOB files "${PREFIX}/lib*/cmake/arbox/arbox-io-targets*" "${PREFIX}/lib*/*/cmake/arbox/arbox-io-targets*")
file(REMOVE ${files})
refused("'io' is not installed; installed components: base, geometry"
  ${configure} "-DCOMPONENTS=io" -S "${HERE}/probe" -B "${WORK}/probe_missing")
file(REMOVE_RECURSE "${WORK}")
