# examples/consumer, copied out of the tree.
include("${CMAKE_CURRENT_LIST_DIR}/run_commands.cmake")
set(WORK "${WORK}_consumer")
file(REMOVE_RECURSE "${WORK}")
file(COPY "${ROOT}/examples/consumer" DESTINATION "${WORK}")
run("" ${configure} -S "${WORK}/consumer" -B "${WORK}/build")
run("" ${CMAKE_COMMAND} --build "${WORK}/build")
run("a fifth of the draws hold" "${WORK}/build/consumer" "${ROOT}/examples/data/street.bin")
refused("missing.bin: no such file" "${WORK}/build/consumer" missing.bin)
refused("nearest is 'cluster_fit'"
  "${WORK}/build/consumer" "${ROOT}/examples/data/street.bin" cluster_fat)
if(NOT "$ENV{ARBOX_DATA}" STREQUAL "")
  run("a fifth of the draws hold"
    "${WORK}/build/consumer" "$ENV{ARBOX_DATA}/kitti/training/velodyne/000008.bin")
endif()
file(REMOVE_RECURSE "${WORK}")
