#include "arbox/sparse/internal/point_kernel.h"

#include "arbox/base/internal/float_lanes.h"

// Compiled three times; see arbox_simd_sources in cmake/ArboxTargets.cmake.

namespace arbox::sparse::internal::ARBOX_SIMD {

using namespace arbox::internal::ARBOX_SIMD;

std::int64_t farthest_step(const FarthestState& state, std::int64_t chosen) {
  const float cx = state.x[chosen], cy = state.y[chosen], cz = state.z[chosen];
  Vector best = Vector{} - 1.0f;
  Integers best_block = {};
  const std::int64_t whole = state.count / kLanes * kLanes;
  for (std::int64_t i = 0; i < whole; i += kLanes) {
    const Vector dx = load(state.x + i) - cx, dy = load(state.y + i) - cy,
                 dz = load(state.z + i) - cz;
    const Vector squared = dx * dx + dy * dy + dz * dz;
    const Vector before = load(state.distance + i);
    const Vector now = squared < before ? squared : before;
    store(state.distance + i, now);
    const Integers better = now > best;
    best = better ? now : best;
    best_block = better ? Integers{} + static_cast<std::int32_t>(i / kLanes) : best_block;
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
