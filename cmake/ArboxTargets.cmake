# The helpers that every room uses to declare its library, tests and benchmarks.

# Headers stand beside their sources; this link makes <arbox/room/file.h> true in the build tree.
file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/include")
file(CREATE_LINK "${CMAKE_SOURCE_DIR}" "${CMAKE_BINARY_DIR}/include/arbox" SYMBOLIC)

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}:$ORIGIN")

function(arbox_compile_options target)
  if(ARBOX_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link -fno-sanitize-recover=undefined)
  endif()
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC bug 105651: false alarms on "text" + std::string.
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(ARBOX_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(ARBOX_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${ARBOX_SANITIZE} -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${ARBOX_SANITIZE})
  endif()
endfunction()

# arbox_install(component target [used targets...])
# Installs and exports a target as arbox::<component>, and notes what find_package must load for it:
# the components that it uses, and the packages of its public third-party targets.
function(arbox_install component target)
  set(needs "")
  set(packages "")
  foreach(used IN LISTS ARGN)
    if(used MATCHES "^arbox::(.+)$")
      list(APPEND needs ${CMAKE_MATCH_1})
    elseif(used STREQUAL "Eigen3::Eigen")
      list(APPEND packages Eigen3)
    elseif(used MATCHES "^torch$")
      list(APPEND packages Torch)
    elseif(used MATCHES "^pcl_")
      list(APPEND packages PCL)
    endif()
  endforeach()
  list(REMOVE_DUPLICATES packages)
  set_property(GLOBAL APPEND PROPERTY arbox_targets ${target})
  set_property(GLOBAL APPEND PROPERTY arbox_components ${component})
  set_property(GLOBAL APPEND_STRING PROPERTY arbox_component_table
    "set(arbox_needs_${component} \"${needs}\")\nset(arbox_packages_${component} \"${packages}\")\n")
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${component})
  install(TARGETS ${target} EXPORT arbox-${component}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
  install(EXPORT arbox-${component} NAMESPACE arbox:: FILE arbox-${component}-targets.cmake
    DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/arbox" COMPONENT ${component})
endfunction()

# arbox_keep_memory(program) gives a program that runs networks the allocator of `arbox`.
function(arbox_keep_memory target)
  # Sanitizers bring an allocator of their own.
  if(NOT ARBOX_SANITIZE)
    target_sources(${target} PRIVATE "${CMAKE_SOURCE_DIR}/cli/memory_allocator.cpp")
    target_link_libraries(${target} PRIVATE PkgConfig::jemalloc)
  endif()
endfunction()

# arbox_library(room SOURCES ... [PUBLIC targets...] [PRIVATE targets...])
# One room is one library: target arbox_<room>, alias arbox::<room>, install component <room>.
function(arbox_library room)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target arbox_${room})
  file(RELATIVE_PATH folder "${CMAKE_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  add_library(${target} ${ARG_SOURCES})
  add_library(arbox::${room} ALIAS ${target})
  arbox_compile_options(${target})
  target_include_directories(${target} PUBLIC
    "$<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/include>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  arbox_precompile(${target} library "${ARG_PUBLIC};${ARG_PRIVATE}")
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
  arbox_install(${room} ${target} ${ARG_PUBLIC} ${ARG_PRIVATE})
  install(DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}/"
    DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/arbox/${folder}" COMPONENT ${room}
    FILES_MATCHING PATTERN "*.h" PATTERN "internal" EXCLUDE)
endfunction()

# arbox_simd_sources(target file.cpp...)
# Compiles each file three times, in namespaces scalar, avx2 and avx512 (macro ARBOX_SIMD).
# Such a file includes no Eigen and calls no inline library function that another file might share:
# the linker could keep the copy with the wider instructions and run it on a CPU that lacks them.
function(arbox_simd_sources target)
  foreach(source IN LISTS ARGN)
    get_filename_component(name ${source} NAME_WE)
    foreach(level scalar avx2 avx512)
      set(copy "${CMAKE_CURRENT_BINARY_DIR}/${name}_${level}.cpp")
      file(GENERATE OUTPUT ${copy}
        CONTENT "#define ARBOX_SIMD ${level}\n#include \"${CMAKE_CURRENT_SOURCE_DIR}/${source}\"\n")
      target_sources(${target} PRIVATE ${copy})
      set(flags "")
      if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
        if(level STREQUAL "avx2")
          set(flags "-mavx2;-mfma")
        elseif(level STREQUAL "avx512")
          set(flags "-mavx512f;-mavx512dq;-mavx512bw;-mavx512vl;-mavx2;-mfma;-mprefer-vector-width=512")
        endif()
      endif()
      set_source_files_properties(${copy} PROPERTIES COMPILE_OPTIONS "${flags}"
        SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
    endforeach()
  endforeach()
endfunction()

# arbox_test(room name SOURCES ... [LIBS ...] [EVERY_SIMD_LEVEL])
# Builds one GoogleTest program, one ctest entry a case; the target <room>_tests builds all of a room.
# With EVERY_SIMD_LEVEL the program is run as a whole at each level of kernels, too; ctest skips
# levels that this CPU lacks, with the library's message.
function(arbox_test room name)
  cmake_parse_arguments(ARG "EVERY_SIMD_LEVEL" "TIMEOUT" "SOURCES;LIBS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set(target ${room}_${name}_test)
  add_executable(${target} ${ARG_SOURCES})
  arbox_compile_options(${target})
  target_include_directories(${target} PRIVATE "${CMAKE_SOURCE_DIR}/tests")
  target_link_libraries(${target} PRIVATE ${ARG_LIBS} arbox_test_support GTest::gmock GTest::gtest_main)
  if(TARGET arbox::${room})
    target_link_libraries(${target} PRIVATE arbox::${room})
  endif()
  arbox_precompile(${target} test "${ARG_LIBS};arbox::${room}")
  arbox_bundle(${target})
  gtest_discover_tests(${target} TEST_PREFIX "${room}." DISCOVERY_MODE PRE_TEST
    PROPERTIES LABELS ${room} TIMEOUT ${ARG_TIMEOUT}
    ENVIRONMENT "ARBOX_PROGRAM=${CMAKE_BINARY_DIR}/bin/arbox")
  if(ARG_EVERY_SIMD_LEVEL)
    foreach(level scalar avx2 avx512)
      add_test(NAME ${room}.${name}_at_${level} COMMAND ${target})
      set_tests_properties(${room}.${name}_at_${level} PROPERTIES
        LABELS ${room} TIMEOUT ${ARG_TIMEOUT} ENVIRONMENT "ARBOX_SIMD=${level}"
        SKIP_REGULAR_EXPRESSION "ARBOX_SIMD: this CPU has no")
    endforeach()
  endif()
  if(NOT TARGET ${room}_tests)
    add_custom_target(${room}_tests)
  endif()
  add_dependencies(${room}_tests ${target})
endfunction()

# arbox_benchmark(name SOURCES ... [LIBS ...]) builds one Google Benchmark program.
function(arbox_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name}_benchmark ${ARG_SOURCES})
  arbox_compile_options(${name}_benchmark)
  target_include_directories(${name}_benchmark PRIVATE "${CMAKE_SOURCE_DIR}/tests")
  target_link_libraries(${name}_benchmark PRIVATE ${ARG_LIBS} benchmark::benchmark benchmark::benchmark_main)
endfunction()
