#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

/// \file
/// Vectors of doubles as wide as the instruction set that a kernel source is compiled for. Only for
/// sources listed in arbox_simd_sources: everything lives in the namespace of their level, so that
/// no two levels share a function.

namespace arbox::geometry::ARBOX_SIMD {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX2__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

/// kLanes doubles; arithmetic and `mask ? a : b` work lane by lane.
typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
/// The result of comparing Lanes: all bits of a lane set or none.
typedef long long LaneMask __attribute__((vector_size(kLanes * sizeof(double))));
/// Lanes at any address.
typedef double LanesUnaligned
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(sizeof(double)), may_alias));

inline Lanes load(const double* from) { return *reinterpret_cast<const LanesUnaligned*>(from); }
inline Lanes broadcast(double value) { return value - Lanes{}; }
inline Lanes minimum(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes maximum(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes clamp(Lanes value, Lanes low, Lanes high) {
  return minimum(maximum(value, low), high);
}
inline Lanes magnitude(Lanes a) { return maximum(a, -a); }

/// Bit i is set if lane i of the mask is.
inline unsigned bits(LaneMask mask) {
#if defined(__AVX512F__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
#elif defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#elif defined(__x86_64__)
  return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(mask)));
#else
  unsigned result = 0;
  for (int lane = 0; lane < kLanes; ++lane) result |= mask[lane] ? 1u << lane : 0u;
  return result;
#endif
}

}  // namespace arbox::geometry::ARBOX_SIMD
