#pragma once

#include <cstddef>
#include <cstdint>

/// \file
/// The C side of a plugin: what is compared before any C++ crosses the boundary. A plugin's author
/// needs only base/plugin.h, which fills all of this in.

extern "C" {

/// How a library was built. Two libraries may exchange C++ objects only if all of it is equal.
struct ArboxBuildFingerprint {
  const char* compiler;
  const char* standard_library;
  /// LibTorch's version for kinds that pass tensors, "" for others.
  const char* libtorch;
  std::uint32_t cpp_standard;
  std::uint32_t eigen_max_align_bytes;
  /// 1 if assertions are off.
  std::uint32_t ndebug;
};

/// What a plugin says of itself. `struct_size` and `abi` stay first in every version.
struct ArboxPluginInfo {
  std::uint32_t struct_size;
  std::uint32_t abi;
  const char* kind;
  const char* name;
  const char* version;
  const char* licence;
  ArboxBuildFingerprint build;
};

}  // extern "C"

#define ARBOX_TEXT_OF(value) #value
#define ARBOX_TEXT(value) ARBOX_TEXT_OF(value)

#if defined(__clang__)
#define ARBOX_COMPILER "clang " ARBOX_TEXT(__clang_major__)
#else
#define ARBOX_COMPILER "gcc " ARBOX_TEXT(__GNUC__)
#endif

#if defined(_GLIBCXX_USE_CXX11_ABI)
#define ARBOX_STANDARD_LIBRARY "libstdc++ cxx11 abi " ARBOX_TEXT(_GLIBCXX_USE_CXX11_ABI)
#else
#define ARBOX_STANDARD_LIBRARY "other"
#endif

// Eigen's own rule, so that nobody needs its headers here: an earlier include or a -D decides, else
// the widest vectors that the compiler may use.
#if defined(EIGEN_MAX_ALIGN_BYTES)
#define ARBOX_EIGEN_MAX_ALIGN_BYTES EIGEN_MAX_ALIGN_BYTES
#elif defined(__AVX512F__)
#define ARBOX_EIGEN_MAX_ALIGN_BYTES 64
#elif defined(__AVX__)
#define ARBOX_EIGEN_MAX_ALIGN_BYTES 32
#else
#define ARBOX_EIGEN_MAX_ALIGN_BYTES 16
#endif

#if defined(NDEBUG)
#define ARBOX_NDEBUG 1
#else
#define ARBOX_NDEBUG 0
#endif

namespace arbox {

/// Raised whenever ArboxPluginInfo, Registrar or the meaning of either changes.
inline constexpr std::uint32_t kPluginAbi = 1;

/// The fingerprint of the translation unit that calls it: evaluated at compile time, so that no
/// library can end up with another one's answer.
consteval ArboxBuildFingerprint build_fingerprint(
    const char* libtorch = "", const char* compiler = ARBOX_COMPILER,
    const char* standard_library = ARBOX_STANDARD_LIBRARY,
    std::uint32_t cpp_standard = static_cast<std::uint32_t>(__cplusplus),
    std::uint32_t eigen_max_align_bytes = ARBOX_EIGEN_MAX_ALIGN_BYTES,
    std::uint32_t ndebug = ARBOX_NDEBUG) {
  return {compiler, standard_library, libtorch, cpp_standard, eigen_max_align_bytes, ndebug};
}

}  // namespace arbox
