#pragma once

#include <cstdint>

// The inner loops of a multilayer perceptron and of softmax, free of frameworks. Compiled once for
// each instruction set, in the namespaces scalar, avx2 and avx512. A number of the result depends
// on its own row alone: not on how many rows run together, nor on where the row stands.

namespace arbox::heads::internal {

/// Outputs of a layer are padded to a multiple of this; softmax sums in blocks of it.
inline constexpr std::int32_t kColumnBlock = 64;

/// output = leaky(input * weight^T + bias), where leaky(x) = x > 0 ? x : leak * x.
struct LayerRun {
  const float* input = nullptr;
  std::int64_t input_stride = 0;
  float* output = nullptr;
  std::int64_t output_stride = 0;
  std::int64_t rows = 0;
  /// Panels of panel_columns() outputs, each (in, panel_columns()), row-major.
  const float* weight = nullptr;
  const float* bias = nullptr;  ///< (columns).
  std::int32_t in = 0;
  std::int32_t columns = 0;  ///< Padded.
  float leak = 1.0f;
};

/// output = leaky(base + values[0] * column 0 + values[1] * column 1 + ...): one row.
struct PrefixRun {
  const float* base = nullptr;
  const float* values = nullptr;
  std::int32_t count = 0;
  const float* columns_of_values = nullptr;  ///< (count, columns), row-major.
  std::int32_t columns = 0;                  ///< Padded.
  float leak = 1.0f;
  float* output = nullptr;
};

struct MlpKernels {
  std::int32_t (*panel_columns)();
  void (*layer)(const LayerRun& run);
  void (*add_prefix)(const PrefixRun& run);
  /// Largest of a padded row of logits.
  float (*largest)(const float* logits, std::int32_t columns);
  /// values = exp((logits - top) * scale); sums: of each block of kColumnBlock columns.
  void (*exponentials)(const float* logits, std::int32_t columns, float top, float scale,
                       float* values, float* sums);
};

#define ARBOX_HEADS_MLP_KERNELS(level)                                                 \
  namespace level {                                                                    \
  std::int32_t panel_columns();                                                        \
  void layer(const LayerRun& run);                                                     \
  void add_prefix(const PrefixRun& run);                                               \
  float largest(const float* logits, std::int32_t columns);                            \
  void exponentials(const float* logits, std::int32_t columns, float top, float scale, \
                    float* values, float* sums);                                       \
  }
ARBOX_HEADS_MLP_KERNELS(scalar)
ARBOX_HEADS_MLP_KERNELS(avx2)
ARBOX_HEADS_MLP_KERNELS(avx512)
#undef ARBOX_HEADS_MLP_KERNELS

/// Those of simd_level().
const MlpKernels& mlp_kernels();

}  // namespace arbox::heads::internal
