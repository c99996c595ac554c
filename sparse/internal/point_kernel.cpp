#include "arbox/sparse/internal/point_kernel.h"

// Compiled three times; see arbox_simd_sources in cmake/ArboxTargets.cmake.

#if defined(__AVX512F__)
#define ARBOX_LANES 16
#elif defined(__AVX2__)
#define ARBOX_LANES 8
#else
#define ARBOX_LANES 4
#endif

namespace arbox::sparse::internal::ARBOX_SIMD {
namespace {

constexpr int kLanes = ARBOX_LANES;
typedef float Vector __attribute__((vector_size(kLanes * sizeof(float))));
typedef float Unaligned __attribute__((vector_size(kLanes * sizeof(float)), aligned(4)));
typedef std::int32_t Index __attribute__((vector_size(kLanes * sizeof(float))));

inline Vector load(const float* from) {
  return (Vector) * reinterpret_cast<const Unaligned*>(from);
}

}  // namespace

std::int64_t farthest_step(const FarthestState& state, std::int64_t chosen) {
  const float cx = state.x[chosen], cy = state.y[chosen], cz = state.z[chosen];
  Vector best = Vector{} - 1.0f;
  Index best_block = {};
  const std::int64_t whole = state.count / kLanes * kLanes;
  for (std::int64_t i = 0; i < whole; i += kLanes) {
    const Vector dx = load(state.x + i) - cx, dy = load(state.y + i) - cy,
                 dz = load(state.z + i) - cz;
    const Vector squared = dx * dx + dy * dy + dz * dz;
    const Vector before = load(state.distance + i);
    const Vector now = squared < before ? squared : before;
    *reinterpret_cast<Unaligned*>(state.distance + i) = now;
    const Index better = now > best;
    best = better ? now : best;
    best_block = better ? Index{} + static_cast<std::int32_t>(i / kLanes) : best_block;
  }
  float farthest = -1;
  std::int64_t result = 0;
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int64_t at = std::int64_t{best_block[lane]} * kLanes + lane;
    if (best[lane] > farthest || (best[lane] == farthest && at < result)) {
      farthest = best[lane];
      result = at;
    }
  }
  for (std::int64_t i = whole; i < state.count; ++i) {
    const float dx = state.x[i] - cx, dy = state.y[i] - cy, dz = state.z[i] - cz;
    const float squared = dx * dx + dy * dy + dz * dz;
    if (squared < state.distance[i]) state.distance[i] = squared;
    if (state.distance[i] > farthest) {
      farthest = state.distance[i];
      result = i;
    }
  }
  return result;
}

}  // namespace arbox::sparse::internal::ARBOX_SIMD
