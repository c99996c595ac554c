#include "arbox/detectors/pv_rcnn/internal/birds_eye_backbone.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/conv_transpose2d.h>
#include <ATen/ops/relu.h>
#include <ATen/ops/zeros.h>

#include "arbox/base/parallel.h"
#include "arbox/detectors/pv_rcnn/internal/norm_options.h"
#include "arbox/detectors/pv_rcnn/internal/row_layer.h"

namespace arbox::detectors::pv_rcnn::internal {

MapLayer::MapLayer(torch::nn::Module& sequence, int place, std::int64_t in, std::int64_t out,
                   std::int32_t kernel, std::int32_t stride, bool transposed)
    : kernel_(kernel), stride_(stride), transposed_(transposed) {
  const std::int64_t rows = transposed ? in : out, columns = transposed ? out : in;
  weight_ = add_child(sequence, std::to_string(place))
                ->register_parameter("weight", initial_weight({rows, columns, kernel, kernel},
                                                              columns * kernel * kernel));
  norm_ = sequence.register_module(std::to_string(place + 1),
                                   std::make_shared<sparse::BatchNorm>(out, kBackboneEpsilon));
}

FoldedLayer MapLayer::folded() const {
  const auto [scale, shift] = norm_->folded();
  const at::Tensor shaped = transposed_ ? scale.view({1, -1, 1, 1}) : scale.view({-1, 1, 1, 1});
  return {weight_ * shaped, shift, stride_};
}

at::Tensor MapLayer::forward(const at::Tensor& map) const {
  const at::Tensor weight = weight_.contiguous(at::MemoryFormat::ChannelsLast);
  const at::Tensor raw = transposed_ ? at::conv_transpose2d(map, weight, {}, stride_)
                                     : at::conv2d(map, weight, {}, stride_, kernel_ / 2);
  const at::Tensor sums = raw.contiguous(at::MemoryFormat::ChannelsLast).permute({0, 2, 3, 1});
  const at::Tensor rows = norm_->forward(sums.reshape({-1, sums.size(3)}));
  return at::relu(rows).view(sums.sizes()).permute({0, 3, 1, 2});
}

at::Tensor MapLayer::elements() const {
  const at::Tensor last =
      transposed_ ? weight_.permute({2, 3, 0, 1}) : weight_.permute({2, 3, 1, 0});
  return last.reshape({std::int64_t{kernel_} * kernel_, last.size(2), last.size(3)});
}

at::Tensor MapLayer::finish(const sparse::Connection& connection,
                            const at::Tensor& features) const {
  if (sparse::folds(*norm_)) {
    const auto [scale, shift] = norm_->folded();
    return sparse::convolve_fused(connection, features, elements(),
                                  {.scale = scale, .shift = shift, .residual = {}, .relu = true});
  }
  return at::relu(norm_->forward(sparse::convolve(connection, features, elements())));
}

sparse::SparseTensor MapLayer::forward(const sparse::SparseTensor& cells, bool spread) const {
  sparse::Kernel kernel{.size = {kernel_, kernel_, 1}, .stride = {stride_, stride_, 1}};
  if (spread) {
    kernel.padding = {kernel_ / 2, kernel_ / 2, 0};
  } else {
    kernel.submanifold = true;
  }
  const auto connection = cells.manager().convolution(cells.set(), kernel);
  return {connection.outputs, finish(connection, cells.features()), cells};
}

sparse::SparseTensor MapLayer::forward_to(const sparse::SparseTensor& cells,
                                          const sparse::SparseTensor& target) const {
  const sparse::Kernel kernel{.size = {kernel_, kernel_, 1}, .stride = {stride_, stride_, 1}};
  const auto connection = cells.manager().transposed(cells.set(), target.set(), kernel);
  return {connection.outputs, finish(connection, cells.features()), target};
}

BirdsEyeBackbone::BirdsEyeBackbone(const BirdsEyeOptions& options, std::int64_t in_channels) {
  const auto blocks = add_child(*this, "blocks"), ups = add_child(*this, "deblocks");
  std::int64_t channels = in_channels;
  std::int32_t up_stride = 1;
  for (std::size_t i = 0; i < options.channels.size(); ++i) {
    const auto stride = static_cast<std::int32_t>(options.strides[i]);
    if (i > 0) up_stride *= stride;
    const auto sequence = add_child(*blocks, std::to_string(i));
    std::vector<MapLayer>& layers = blocks_.emplace_back();
    for (std::int64_t j = 0; j < options.layers[i]; ++j) {
      // Place 0 of a block is padding, and every layer's rectifier takes one.
      layers.emplace_back(*sequence, static_cast<int>(1 + 3 * j), channels, options.channels[i], 3,
                          j == 0 ? stride : 1, false);
      channels = options.channels[i];
    }
    up_.emplace_back(*add_child(*ups, std::to_string(i)), 0, channels, options.up_channels[i],
                     up_stride, up_stride, true);
  }
}

std::shared_ptr<const MapPlan> BirdsEyeBackbone::plan_for(const at::Tensor& map) const {
  std::uint64_t version = 0;
  for (const auto& tensor : parameters()) version += tensor._version();
  for (const auto& tensor : buffers()) version += tensor._version();
  // Primitives are made for a number of threads.
  const int threads = default_threads();
  const std::scoped_lock lock(plan_mutex_);
  if (plan_ && plan_version_ == version && plan_threads_ == threads &&
      map.sizes() == plan_->sizes()) {
    return plan_;
  }
  std::vector<std::vector<FoldedLayer>> blocks;
  std::vector<FoldedLayer> ups;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    std::vector<FoldedLayer>& block = blocks.emplace_back();
    for (const MapLayer& layer : blocks_[i]) block.push_back(layer.folded());
    ups.push_back(up_[i].folded());
  }
  plan_ = std::make_shared<const MapPlan>(blocks, ups, map.sizes());
  plan_version_ = version;
  plan_threads_ = threads;
  return plan_;
}

at::Tensor BirdsEyeBackbone::forward(const at::Tensor& map) const {
  if (sparse::folds(*this) && map.scalar_type() == at::kFloat && map.is_cpu()) {
    return plan_for(map)->run(map);
  }
  at::Tensor current = map;
  std::vector<at::Tensor> results;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (const MapLayer& layer : blocks_[i]) current = layer.forward(current);
    results.push_back(up_[i].forward(current));
  }
  return at::cat(results, 1);
}

sparse::SparseTensor BirdsEyeBackbone::forward(const sparse::SparseTensor& cells) const {
  sparse::SparseTensor current = cells;
  std::vector<sparse::SparseTensor> firsts;
  std::vector<at::Tensor> results;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (std::size_t j = 0; j < blocks_[i].size(); ++j) {
      current = blocks_[i][j].forward(current, j == 0);
    }
    if (i == 0) firsts.push_back(current);
    results.push_back(up_[i].forward_to(current, firsts.front()).features());
  }
  return firsts.front().with_features(at::cat(results, 1));
}

at::Tensor to_map(const sparse::SparseTensor& cells) {
  const auto& [x, y, z] = *cells.lattice().grid;
  const std::int64_t batch = cells.batch_size(), channels = cells.channels();
  const at::Tensor places = cells.coordinates().to(at::kLong);
  const at::Tensor row = (places.select(1, 0) * y + places.select(1, 2)) * x + places.select(1, 1);
  at::Tensor map = at::zeros({batch * y * x, channels, z}, cells.features().options());
  for (std::int64_t layer = 0; layer < z; ++layer) {
    const at::Tensor here = (places.select(1, 3) == layer).nonzero().squeeze(1);
    map.select(2, layer).index_copy_(0, row.index_select(0, here),
                                     cells.features().index_select(0, here));
  }
  return map.view({batch, y, x, channels * z}).permute({0, 3, 1, 2});
}

}  // namespace arbox::detectors::pv_rcnn::internal
