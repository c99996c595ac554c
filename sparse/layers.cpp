#include "arbox/sparse/layers.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/batch_norm.h>
#include <ATen/ops/elu.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/relu.h>
#include <ATen/ops/zeros.h>

#include <cmath>
#include <utility>

namespace arbox::sparse {
namespace {

at::Tensor initial_weight(std::vector<std::int64_t> shape, std::int64_t fan_out) {
  return at::randn(shape) * std::sqrt(2.0 / static_cast<double>(fan_out));
}

}  // namespace

SparseTensor relu(const SparseTensor& input) {
  return input.with_features(at::relu(input.features()));
}

SparseTensor elu(const SparseTensor& input) {
  return input.with_features(at::elu(input.features()));
}

bool folds(const torch::nn::Module& module) {
  return !module.is_training() && !at::GradMode::is_enabled();
}

BatchNorm::BatchNorm(std::int64_t channels, double epsilon, double momentum)
    : weight_(register_parameter("weight", at::ones({channels}))),
      bias_(register_parameter("bias", at::zeros({channels}))),
      running_mean_(register_buffer("running_mean", at::zeros({channels}))),
      running_var_(register_buffer("running_var", at::ones({channels}))),
      batches_(register_buffer("num_batches_tracked", at::zeros({}, at::kLong))),
      epsilon_(epsilon),
      momentum_(momentum) {}

at::Tensor BatchNorm::forward_shared(const at::Tensor& features,
                                     std::shared_ptr<const SharedStatistics::Sum> sum) {
  const NormStatistics statistics = shared_statistics(features, *sum);
  if (statistics.count < 2) {
    if (features.size(0) == 0) return features;
    return at::batch_norm(features, weight_, bias_, running_mean_, running_var_, false, momentum_,
                          epsilon_, false);
  }
  batches_.add_(1);
  const auto update = [&](at::Tensor& running, const at::Tensor& now) {
    running.mul_(1 - momentum_).add_(now.to(running.scalar_type()), momentum_);
  };
  update(running_mean_, statistics.mean);
  update(running_var_, statistics.variance * (statistics.count / (statistics.count - 1)));
  return shared_batch_norm(features, weight_, bias_, statistics, epsilon_, std::move(sum));
}

at::Tensor BatchNorm::forward(const at::Tensor& features) {
  if (is_training()) {
    if (auto sum = SharedStatistics::current()) return forward_shared(features, std::move(sum));
  }
  const bool training = is_training() && features.size(0) > 1;
  if (features.size(0) == 0) return features;
  if (training) batches_.add_(1);
  return at::batch_norm(features, weight_, bias_, running_mean_, running_var_, training, momentum_,
                        epsilon_, false);
}

BatchNorm::Folded BatchNorm::folded() const {
  const at::Tensor scale = weight_ / (running_var_ + epsilon_).sqrt();
  return {scale, bias_ - running_mean_ * scale};
}

VoxelBatchNorm::VoxelBatchNorm(std::int64_t channels, double epsilon, double momentum)
    : bn_(register_module("bn", std::make_shared<BatchNorm>(channels, epsilon, momentum))) {}

SparseTensor VoxelBatchNorm::forward(const SparseTensor& input) {
  return input.with_features(bn_->forward(input.features()));
}

InstanceNorm::InstanceNorm(std::int64_t channels, double epsilon)
    : weight_(register_parameter("weight", at::ones({1, channels}))),
      bias_(register_parameter("bias", at::zeros({1, channels}))),
      epsilon_(epsilon) {}

SparseTensor InstanceNorm::forward(const SparseTensor& input) {
  const at::Tensor& x = input.features();
  if (input.batch_size() <= 1) {
    if (input.size() == 0) return input;
    const at::Tensor centred = x - x.mean(0, true);
    const at::Tensor deviation = (centred.square().mean(0, true) + epsilon_).sqrt();
    return input.with_features(centred * (weight_ / deviation) + bias_);
  }
  const at::Tensor scene = input.batch_numbers();
  const auto sums = [&](const at::Tensor& values) {
    return at::zeros({input.batch_size(), values.size(1)}, values.options())
        .index_add(0, scene, values);
  };
  const at::Tensor counts = sums(at::ones({input.size(), 1}, x.options())).clamp_min(1);
  const at::Tensor centred = x - (sums(x) / counts).index_select(0, scene);
  const at::Tensor deviation = (sums(centred.square()) / counts + epsilon_).sqrt();
  return input.with_features(centred * (weight_ / deviation).index_select(0, scene) + bias_);
}

Convolution::Convolution(std::int64_t in_channels, std::int64_t out_channels, const Kernel& kernel,
                         bool bias)
    : kernel_(kernel) {
  const bool matrix = kernel.elements() == 1 && kernel.stride == Triple{1, 1, 1};
  std::vector<std::int64_t> shape = {in_channels, out_channels};
  if (!matrix) shape.insert(shape.begin(), kernel.elements());
  weight_ = register_parameter("kernel",
                               initial_weight(std::move(shape), out_channels * kernel.elements()));
  if (bias) bias_ = register_parameter("bias", at::zeros({1, out_channels}));
}

SparseTensor Convolution::forward(const SparseTensor& input) const {
  return convolution(input, weight_, kernel_, bias_);
}

SparseTensor Convolution::generate(const SparseTensor& input) const {
  return generative_convolution(input, weight_, kernel_, bias_);
}

SparseTensor Convolution::transpose(const SparseTensor& input, const SparseTensor& target) const {
  return transposed_convolution(input, target, weight_, kernel_, bias_);
}

FusedEpilogue Convolution::with_bias(FusedEpilogue epilogue) const {
  if (!bias_.defined()) return epilogue;
  at::Tensor shift = bias_.flatten();
  if (epilogue.scale.defined()) shift = shift * epilogue.scale;
  epilogue.shift = epilogue.shift.defined() ? epilogue.shift + shift : shift;
  return epilogue;
}

SparseTensor Convolution::forward_fused(const SparseTensor& input,
                                        const FusedEpilogue& epilogue) const {
  const Connection connection = input.manager().convolution(input.set(), kernel_);
  return {connection.outputs,
          convolve_fused(connection, input.features(), weight_, with_bias(epilogue)), input};
}

SparseTensor Convolution::generate_fused(const SparseTensor& input,
                                         const FusedEpilogue& epilogue) const {
  const Connection connection = input.manager().generative(input.set(), kernel_);
  return {connection.outputs,
          convolve_fused(connection, input.features(), weight_, with_bias(epilogue)), input};
}

GridConvolution::GridConvolution(std::int64_t in_channels, std::int64_t out_channels,
                                 const Kernel& kernel, bool bias)
    : kernel_(kernel),
      weight_(register_parameter(
          "weight", initial_weight(
                        {out_channels, kernel.size[2], kernel.size[1], kernel.size[0], in_channels},
                        out_channels * kernel.elements()))) {
  if (bias) bias_ = register_parameter("bias", at::zeros({out_channels}));
}

at::Tensor GridConvolution::elements() const {
  return weight_.permute({1, 2, 3, 4, 0})
      .reshape({kernel_.elements(), weight_.size(4), weight_.size(0)});
}

SparseTensor GridConvolution::forward(const SparseTensor& input) const {
  return convolution(input, elements(), kernel_, bias_);
}

SparseTensor GridConvolution::forward_fused(const SparseTensor& input,
                                            FusedEpilogue epilogue) const {
  if (bias_.defined()) {
    const at::Tensor shift = epilogue.scale.defined() ? bias_ * epilogue.scale : bias_;
    epilogue.shift = epilogue.shift.defined() ? epilogue.shift + shift : shift;
  }
  const Connection connection = input.manager().convolution(input.set(), kernel_);
  return {connection.outputs, convolve_fused(connection, input.features(), elements(), epilogue),
          input};
}

ResidualBlock::ResidualBlock(std::int64_t in_channels, std::int64_t out_channels,
                             std::int32_t stride)
    : conv1_(register_module(
          "conv1", std::make_shared<Convolution>(in_channels, out_channels,
                                                 Kernel{.stride = {stride, stride, stride}}))),
      conv2_(register_module("conv2", std::make_shared<Convolution>(out_channels, out_channels))),
      norm1_(register_module("norm1", std::make_shared<VoxelBatchNorm>(out_channels))),
      norm2_(register_module("norm2", std::make_shared<VoxelBatchNorm>(out_channels))) {
  if (stride == 1 && in_channels == out_channels) return;
  const auto downsample = register_module("downsample", std::make_shared<torch::nn::Module>());
  shortcut_ = downsample->register_module(
      "0",
      std::make_shared<Convolution>(in_channels, out_channels,
                                    Kernel{.size = {1, 1, 1}, .stride = {stride, stride, stride}}));
  shortcut_norm_ = downsample->register_module("1", std::make_shared<VoxelBatchNorm>(out_channels));
}

SparseTensor ResidualBlock::forward(const SparseTensor& input) {
  if (folds(*this)) return forward_fused(input);
  const SparseTensor shortcut =
      shortcut_ ? shortcut_norm_->forward(shortcut_->forward(input)) : input;
  const SparseTensor hidden = relu(norm1_->forward(conv1_->forward(input)));
  const SparseTensor output = norm2_->forward(conv2_->forward(hidden));
  return output.with_features(at::relu(output.features() + shortcut.features()));
}

SparseTensor ResidualBlock::forward_fused(const SparseTensor& input) {
  at::Tensor residual = input.features();
  if (shortcut_) {
    const auto [scale, shift] = shortcut_norm_->folded();
    residual = shortcut_->forward_fused(input, {.scale = scale, .shift = shift, .residual = {}})
                   .features();
  }
  const auto [scale1, shift1] = norm1_->folded();
  const SparseTensor hidden = conv1_->forward_fused(
      input, {.scale = scale1, .shift = shift1, .residual = {}, .relu = true});
  const auto [scale2, shift2] = norm2_->folded();
  return conv2_->forward_fused(
      hidden, {.scale = scale2, .shift = shift2, .residual = residual, .relu = true});
}

}  // namespace arbox::sparse
