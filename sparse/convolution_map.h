#pragma once

#include <cstdint>
#include <span>

#include "arbox/sparse/kernel_map.h"

/// \file
/// Sparse convolution over a ready kernel map, without tensors. sparse/convolution.h wraps it for
/// autograd.

namespace arbox::sparse {

/// What happens to an output row after its sum: row * scale + shift + residual row, then the
/// rectifier. Folded batch norm, bias and shortcut. What is empty is left out.
struct Epilogue {
  std::span<const float> scale = {};  ///< (out_channels)
  std::span<const float> shift = {};  ///< (out_channels)
  const float* residual = nullptr;    ///< (outputs, out_channels), rows as those of the output
  bool relu = false;
};

/// Which rows of the caller's tensors the positions of a kernel map are.
struct MapRows {
  std::span<const std::int32_t> inputs, outputs;
};

/// output[o] = epilogue(sum over pairs (i, o) of element k: input[i] * weight[k]).
///
/// input (inputs, in_channels), weight (elements, in_channels, out_channels), output (outputs,
/// out_channels): float32, row-major, rows in the caller's order. Every row of the output is
/// written. The result is the same at any thread count. Workspace: the packed weights and, for each
/// thread, one tile of at most 256 output rows.
void convolve(const KernelMap& map, const MapRows& rows, const float* input, const float* weight,
              std::int32_t in_channels, std::int32_t out_channels, float* output,
              const Epilogue& epilogue = {}, int threads = 0);

/// gradient_input[i] = sum over pairs (i, o) of element k: gradient_output[o] * weight[k]^T.
void convolve_input_gradient(const KernelMap& map, const MapRows& rows,
                             const float* gradient_output, const float* weight,
                             std::int32_t in_channels, std::int32_t out_channels,
                             float* gradient_input, int threads = 0);

/// gradient_weight[k] = sum over pairs (i, o) of element k: input[i]^T * gradient_output[o].
///
/// The outputs are cut into ranges (as many as the shapes say, not the threads) whose partial sums
/// are added in order, so that the result is the same at any thread count. Workspace: the partial
/// sums, at most 32 MB or one gradient.
void convolve_weight_gradient(const KernelMap& map, const MapRows& rows, const float* input,
                              const float* gradient_output, std::int32_t in_channels,
                              std::int32_t out_channels, float* gradient_weight, int threads = 0);

}  // namespace arbox::sparse
