#include "arbox/detectors/pv_rcnn/internal/sparse_backbone.h"

#include <ATen/ops/relu.h>

#include "arbox/detectors/pv_rcnn/internal/norm_options.h"
#include "arbox/detectors/pv_rcnn/internal/row_layer.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

constexpr std::int64_t kInputChannels = 4;

sparse::Kernel halving(const BackboneOptions& options, std::size_t level) {
  const std::int32_t size = options.down_kernel;
  sparse::Kernel kernel{.size = {size, size, size}, .stride = {2, 2, 2}};
  if (size == 3) {
    kernel.padding = {1, 1, static_cast<std::int32_t>(options.vertical_padding[level - 1])};
  }
  return kernel;
}

}  // namespace

VoxelLayer::VoxelLayer(torch::nn::Module& parent, std::int64_t in, std::int64_t out,
                       const sparse::Kernel& kernel)
    : convolution_(
          parent.register_module("0", std::make_shared<sparse::GridConvolution>(in, out, kernel))),
      norm_(parent.register_module("1",
                                   std::make_shared<sparse::BatchNorm>(out, kBackboneEpsilon))) {}

sparse::SparseTensor VoxelLayer::forward(const sparse::SparseTensor& input) const {
  if (sparse::folds(*norm_)) {
    const auto [scale, shift] = norm_->folded();
    return convolution_->forward_fused(
        input, {.scale = scale, .shift = shift, .residual = {}, .relu = true});
  }
  const sparse::SparseTensor sums = convolution_->forward(input);
  return sums.with_features(at::relu(norm_->forward(sums.features())));
}

SparseBackbone::SparseBackbone(const BackboneOptions& options) {
  const sparse::Kernel same{.submanifold = true};
  std::int64_t channels = options.channels.front();
  input_.emplace_back(*add_child(*this, "conv_input"), kInputChannels, channels, same);
  for (std::size_t level = 0; level < options.channels.size(); ++level) {
    const auto sequence = add_child(*this, "conv" + std::to_string(level + 1));
    std::vector<VoxelLayer>& layers = levels_.emplace_back();
    for (std::int64_t i = 0; i < options.layers[level]; ++i) {
      const bool first = level > 0 && i == 0;
      layers.emplace_back(*add_child(*sequence, std::to_string(i)), channels,
                          options.channels[level], first ? halving(options, level) : same);
      channels = options.channels[level];
    }
  }
  output_.emplace_back(
      *add_child(*this, "conv_out"), channels, options.out_channels,
      sparse::Kernel{.size = {1, 1, options.out_kernel}, .stride = {1, 1, options.out_stride}});
}

SparseBackbone::Output SparseBackbone::forward(const sparse::SparseTensor& voxels) const {
  sparse::SparseTensor tensor = input_.front().forward(voxels);
  std::vector<sparse::SparseTensor> results;
  for (const std::vector<VoxelLayer>& level : levels_) {
    for (const VoxelLayer& layer : level) tensor = layer.forward(tensor);
    results.push_back(tensor);
  }
  return {std::move(results), output_.front().forward(tensor)};
}

}  // namespace arbox::detectors::pv_rcnn::internal
