#pragma once

#include <cstdint>

// The inner loops of sparse convolution, free of frameworks. Compiled once for each instruction
// set, in the namespaces scalar, avx2 and avx512.

namespace arbox::sparse::internal {

/// One run of pairs: output row += input row * weight. All rows are float32.
struct PairRun {
  const float* const* inputs;  ///< count pointers to rows of `in_channels` numbers.
  float* const* outputs;       ///< count pointers to rows of `out_columns` numbers.
  std::int64_t count;
  const float* weight;  ///< packed by pack_weight.
  std::int32_t in_channels;
  std::int32_t out_columns;  ///< output channels rounded up to a multiple of kLanes.
};

/// Sum over pairs of the outer product of input row and gradient row, added to `gradient`.
struct WeightGradientRun {
  const float* const* inputs;   ///< count pointers to rows of `in_channels` numbers.
  const float* const* outputs;  ///< count pointers to rows of `out_columns` numbers.
  std::int64_t count;
  float* gradient;  ///< (in_channels, out_columns), row-major.
  std::int32_t in_channels;
  std::int32_t out_columns;  ///< a multiple of lanes().
};

/// A (in_channels, out_channels) matrix in memory: element (i, o) is at i * in_step + o * out_step.
struct WeightMatrix {
  const float* data;
  std::int64_t in_step, out_step;
  std::int32_t in_channels, out_channels;
};

#define ARBOX_SPARSE_KERNELS(level)                                                      \
  namespace level {                                                                      \
  std::int32_t lanes();                                                                  \
  void pack_weight(const WeightMatrix& weight, std::int32_t out_columns, float* packed); \
  void accumulate(const PairRun& run);                                                   \
  void accumulate_weight_gradient(const WeightGradientRun& run);                         \
  }
ARBOX_SPARSE_KERNELS(scalar)
ARBOX_SPARSE_KERNELS(avx2)
ARBOX_SPARSE_KERNELS(avx512)
#undef ARBOX_SPARSE_KERNELS

}  // namespace arbox::sparse::internal
