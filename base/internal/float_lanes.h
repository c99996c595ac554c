#pragma once

/// \file
/// Vectors of floats as wide as the instruction set that a kernel source is compiled for. Only for
/// sources listed in arbox_simd_sources: everything lives in the namespace of their level, so that
/// no two levels share a function.

namespace arbox::internal::ARBOX_SIMD {

#if defined(__AVX512F__)
inline constexpr int kLanes = 16;
#elif defined(__AVX2__)
inline constexpr int kLanes = 8;
#else
inline constexpr int kLanes = 4;
#endif

/// kLanes floats; arithmetic and `mask ? a : b` work lane by lane.
typedef float Vector __attribute__((vector_size(kLanes * sizeof(float))));
/// As many integers; what comparing Vectors gives, too.
typedef int Integers __attribute__((vector_size(kLanes * sizeof(float))));
/// A Vector at any address.
typedef float UnalignedVector
    __attribute__((vector_size(kLanes * sizeof(float)), aligned(sizeof(float)), may_alias));

inline Vector load(const float* from) { return *reinterpret_cast<const UnalignedVector*>(from); }
inline void store(float* to, Vector value) { *reinterpret_cast<UnalignedVector*>(to) = value; }

}  // namespace arbox::internal::ARBOX_SIMD
