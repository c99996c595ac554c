#pragma once

#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include <memory>

#include "arbox/sparse/convolution.h"
#include "arbox/sparse/shared_statistics.h"

/// \file
/// Trainable layers on sparse tensors. Parameter names are those of published checkpoints:
/// `kernel` (MinkowskiEngine), `weight` (spconv), `bn.weight` inside a voxel batch norm.
///
/// A layer whose module is in eval mode, called without gradients (torch::NoGradGuard), folds batch
/// norm, shortcut and rectifier into its convolution.

namespace arbox::sparse {

/// Features through a function; coordinates stay.
SparseTensor relu(const SparseTensor& input);
/// ELU with alpha 1.
SparseTensor elu(const SparseTensor& input);

/// Batch norm over the rows of a matrix (N, C), which are the active voxels of the whole batch.
/// Parameters weight, bias; buffers running_mean, running_var, num_batches_tracked.
/// Training on fewer than two rows uses the running statistics and leaves them alone. Under
/// SharedStatistics the rows are those of all processes.
class BatchNorm : public torch::nn::Module {
 public:
  explicit BatchNorm(std::int64_t channels, double epsilon = 1e-5, double momentum = 0.1);
  at::Tensor forward(const at::Tensor& features);

  /// What inference does to x: x * scale + shift.
  struct Folded {
    at::Tensor scale, shift;
  };
  Folded folded() const;

  /// How much of the running statistics a new batch replaces, in 0..1.
  void set_momentum(double momentum) { momentum_ = momentum; }

 private:
  at::Tensor forward_shared(const at::Tensor& features,
                            std::shared_ptr<const SharedStatistics::Sum> sum);

  at::Tensor weight_, bias_, running_mean_, running_var_, batches_;
  double epsilon_, momentum_;
};

/// BatchNorm as a child named `bn`, as MinkowskiEngine's checkpoints have it.
class VoxelBatchNorm : public torch::nn::Module {
 public:
  explicit VoxelBatchNorm(std::int64_t channels, double epsilon = 1e-5, double momentum = 0.1);
  SparseTensor forward(const SparseTensor& input);
  BatchNorm::Folded folded() const { return bn_->folded(); }

 private:
  std::shared_ptr<BatchNorm> bn_;
};

/// Per scene and channel: (x - mean) / sqrt(biased variance + 1e-8) * weight + bias, always with
/// the scene's own statistics. weight and bias are (1, C).
class InstanceNorm : public torch::nn::Module {
 public:
  explicit InstanceNorm(std::int64_t channels, double epsilon = 1e-8);
  SparseTensor forward(const SparseTensor& input);

 private:
  at::Tensor weight_, bias_;
  double epsilon_;
};

/// Convolution of unbounded tensors; parameter `kernel` (elements, in, out), or (in, out) for a
/// 1x1x1 kernel of stride 1, and `bias` (1, out) if asked. Kaiming normal initialisation by fan
/// out.
class Convolution : public torch::nn::Module {
 public:
  Convolution(std::int64_t in_channels, std::int64_t out_channels, const Kernel& kernel = {},
              bool bias = false);
  SparseTensor forward(const SparseTensor& input) const;
  /// All children (generative_convolution).
  SparseTensor generate(const SparseTensor& input) const;
  /// To the voxels of `target` (transposed_convolution).
  SparseTensor transpose(const SparseTensor& input, const SparseTensor& target) const;
  /// With what follows it folded in; no gradient. The bias is part of the shift.
  SparseTensor forward_fused(const SparseTensor& input, const FusedEpilogue& epilogue) const;
  SparseTensor generate_fused(const SparseTensor& input, const FusedEpilogue& epilogue) const;

  const at::Tensor& weight() const { return weight_; }

 private:
  FusedEpilogue with_bias(FusedEpilogue epilogue) const;

  Kernel kernel_;
  at::Tensor weight_, bias_;
};

/// Convolution of grid-bounded tensors; parameter `weight` (out, kz, ky, kx, in) as spconv 2 lays
/// it, and `bias` (out) if asked. spconv 1 checkpoints (kz, ky, kx, in, out) need
/// permute(4, 0, 1, 2, 3) on loading.
class GridConvolution : public torch::nn::Module {
 public:
  GridConvolution(std::int64_t in_channels, std::int64_t out_channels, const Kernel& kernel,
                  bool bias = false);
  SparseTensor forward(const SparseTensor& input) const;
  SparseTensor forward_fused(const SparseTensor& input, FusedEpilogue epilogue) const;

 private:
  at::Tensor elements() const;

  Kernel kernel_;
  at::Tensor weight_, bias_;
};

/// conv k3 (stride) - norm - ReLU - conv k3 - norm - add shortcut - ReLU. Children conv1, norm1,
/// conv2, norm2, and with stride or other channels downsample.0 (1x1x1 convolution of that stride)
/// and downsample.1 (norm). The shortcut reads only the voxel exactly at the output's coordinate;
/// where it is empty the shortcut is 0 before its norm (docs/sparse.md).
class ResidualBlock : public torch::nn::Module {
 public:
  ResidualBlock(std::int64_t in_channels, std::int64_t out_channels, std::int32_t stride = 1);
  SparseTensor forward(const SparseTensor& input);

 private:
  SparseTensor forward_fused(const SparseTensor& input);

  std::shared_ptr<Convolution> conv1_, conv2_, shortcut_;
  std::shared_ptr<VoxelBatchNorm> norm1_, norm2_, shortcut_norm_;
};

/// True if `module` is in eval mode and no gradient is asked: its layers may be folded.
bool folds(const torch::nn::Module& module);

}  // namespace arbox::sparse
