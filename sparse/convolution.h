#pragma once

#include <ATen/core/Tensor.h>

#include "arbox/sparse/kernel_geometry.h"
#include "arbox/sparse/sparse_tensor.h"

/// \file
/// Differentiable sparse convolutions. Weights are (elements, in_channels, out_channels) with the
/// elements numbered x fastest (kernel_geometry.h); a (in_channels, out_channels) matrix serves for
/// a kernel of one element. bias is (out_channels), (1, out_channels) or undefined.
///
/// float32 on the CPU runs Arbox's own kernels (convolution_map.h): same bytes at any thread count.
/// float64, and every type on another device, runs a plain gather, matrix product and scatter by
/// LibTorch. Gradients reach features, weight and bias. All throw InvalidArgument for shapes, types
/// or devices that do not fit; an empty tensor gives an empty result.

namespace arbox::sparse {

/// Strided or submanifold convolution; which voxels come out: output_coordinates.
SparseTensor convolution(const SparseTensor& input, const at::Tensor& weight, const Kernel& kernel,
                         const at::Tensor& bias = {});

/// From the voxels of `input` to those of `target`, whose stride is `kernel.stride` times finer:
/// the adjoint of convolution(target, ...) in space (spconv's inverse convolution).
SparseTensor transposed_convolution(const SparseTensor& input, const SparseTensor& target,
                                    const at::Tensor& weight, const Kernel& kernel,
                                    const at::Tensor& bias = {});

/// From each voxel to all of its children: sum over elements k of in[c] * weight[k] at
/// c + offset_k * output stride.
SparseTensor generative_convolution(const SparseTensor& input, const at::Tensor& weight,
                                    const Kernel& kernel, const at::Tensor& bias = {});

/// The features of a convolution over a known connection: (inputs, in_channels) to
/// (outputs, out_channels). What the functions above call.
at::Tensor convolve(const Connection& connection, const at::Tensor& features,
                    const at::Tensor& weight, const at::Tensor& bias = {});

/// What inference does to the outputs in the same pass: outputs * scale + shift + residual, then
/// the rectifier. Undefined tensors are left out.
struct FusedEpilogue {
  at::Tensor scale = {};     ///< (out_channels): folded batch norm.
  at::Tensor shift = {};     ///< (out_channels): folded batch norm and bias.
  at::Tensor residual = {};  ///< (outputs, out_channels): shortcut.
  bool relu = false;
};

/// convolve() with its epilogue in one pass, for inference: the result has no gradient.
at::Tensor convolve_fused(const Connection& connection, const at::Tensor& features,
                          const at::Tensor& weight, const FusedEpilogue& epilogue);

}  // namespace arbox::sparse
