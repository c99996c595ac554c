# Variables: PREFIX (installation), WORK (scratch folder), COMPILER, BUILD_TYPE, FLAGS, ROOT.

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
