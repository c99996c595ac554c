#pragma once

#include <cstdint>

// Inner loops over points, free of frameworks. Compiled once for each instruction set, without
// contraction of products and sums: every level picks the same points.

namespace arbox::sparse::internal {

/// Points as three arrays, with the squared distance of each to the chosen ones so far.
struct FarthestState {
  const float* x;
  const float* y;
  const float* z;
  float* distance;
  std::int64_t count;
};

#define ARBOX_SPARSE_POINT_KERNELS(level)                                                  \
  namespace level {                                                                        \
  /* Lowers the distances by point `chosen`; gives the earliest point with the largest. */ \
  std::int64_t farthest_step(const FarthestState& state, std::int64_t chosen);             \
  }
ARBOX_SPARSE_POINT_KERNELS(scalar)
ARBOX_SPARSE_POINT_KERNELS(avx2)
ARBOX_SPARSE_POINT_KERNELS(avx512)
#undef ARBOX_SPARSE_POINT_KERNELS

}  // namespace arbox::sparse::internal
