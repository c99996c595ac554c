# Headers that many files include, parsed once a build instead of once a file; and rooms of tensors
# compiled in bundles of files, as LibTorch's headers cost seconds even then. Off for everyday work:
# then each file shows that it includes what it uses, and compiler caches work.
option(ARBOX_QUICK_BUILD "Parse common headers once a build and bundle files of tensors" OFF)

# arbox_header_set(name CODE library|program LIBS targets... HEADERS headers...)
# Code that a compiler prepares for libraries and for programs differs (-fPIC, -fPIE), and so do
# their precompiled headers.
function(arbox_header_set name)
  cmake_parse_arguments(ARG "" "CODE" "LIBS;HEADERS" ${ARGN})
  set(source "${CMAKE_BINARY_DIR}/precompiled/${name}.cpp")
  file(GENERATE OUTPUT "${source}" CONTENT "")
  add_library(arbox_headers_${name} OBJECT EXCLUDE_FROM_ALL "${source}")
  arbox_compile_options(arbox_headers_${name})
  if(ARG_CODE STREQUAL "program")
    set_target_properties(arbox_headers_${name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(arbox_headers_${name} PRIVATE -fPIE)
  endif()
  target_link_libraries(arbox_headers_${name} PRIVATE ${ARG_LIBS})
  target_precompile_headers(arbox_headers_${name} PRIVATE ${ARG_HEADERS})
endfunction()

set(standard_headers <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <map> <memory>
  <optional> <span> <string> <vector>)
# ivalue.h must come before the module header (clang).
set(tensor_headers <ATen/core/ivalue.h> <torch/nn/module.h> <ATen/TensorOperators.h>
  <torch/csrc/autograd/custom_function.h>)
if(ARBOX_QUICK_BUILD)
  arbox_header_set(library CODE library LIBS Eigen3::Eigen
    HEADERS ${standard_headers} <Eigen/Geometry>)
  arbox_header_set(tensor_library CODE library LIBS Eigen3::Eigen ${TORCH_LIBRARIES}
    HEADERS ${standard_headers} <Eigen/Geometry> ${tensor_headers})
  arbox_header_set(program CODE program
    LIBS Eigen3::Eigen CLI11::CLI11 spdlog::spdlog nlohmann_json::nlohmann_json
    HEADERS ${standard_headers} <Eigen/Geometry> <CLI/CLI.hpp> <nlohmann/json.hpp>)
  if(ARBOX_BUILD_TESTS)
    arbox_header_set(test CODE program LIBS Eigen3::Eigen GTest::gmock
      HEADERS ${standard_headers} <Eigen/Geometry> <gmock/gmock.h> <gtest/gtest.h>)
    arbox_header_set(tensor_test CODE program LIBS Eigen3::Eigen GTest::gmock ${TORCH_LIBRARIES}
      HEADERS ${standard_headers} <Eigen/Geometry> <gmock/gmock.h> <gtest/gtest.h>
        ${tensor_headers})
  endif()
endif()

# arbox_precompile(target kind used) with kind library, program or test: the target's files find
# common headers parsed, LibTorch's too if one of the targets that it uses brings them.
set(ARBOX_TENSOR_TARGETS torch arbox::sparse arbox::heads arbox::pv_rcnn arbox::training)
function(arbox_precompile target kind used)
  if(NOT ARBOX_QUICK_BUILD OR OpenMP::OpenMP_CXX IN_LIST used)
    return()
  endif()
  foreach(brings_tensors IN LISTS ARBOX_TENSOR_TARGETS)
    if(brings_tensors IN_LIST used)
      set(kind tensor_${kind})
      break()
    endif()
  endforeach()
  # Targets with flags of their own (CGAL's rounding) parse the headers anew.
  set_target_properties(${target} PROPERTIES PCH_WARN_INVALID OFF)
  target_precompile_headers(${target} REUSE_FROM arbox_headers_${kind})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC bug 105651 again: in precompiled headers it forgets that they are the system's, and raises
    # false alarms inside of std::string. The preset dev has these warnings.
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow
      -Wno-stringop-overread -Wno-error=dangling-pointer -Wno-error=free-nonheap-object
      -Wno-error=maybe-uninitialized -Wno-error=nonnull -Wno-error=use-after-free)
  endif()
endfunction()

# arbox_bundle(target): compiles the target's files eight at a time.
function(arbox_bundle target)
  if(ARBOX_QUICK_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      # To GCC a file that is included is a header, whose types should not hold unnamed ones.
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
endfunction()
