#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "arbox/detectors/pv_rcnn/internal/map_plan.h"
#include "arbox/detectors/pv_rcnn/options.h"
#include "arbox/sparse/layers.h"

namespace arbox::detectors::pv_rcnn::internal {

/// Convolution without bias - batch norm - ReLU over a map, on all of it or on its active cells.
class MapLayer {
 public:
  /// Children `place` and `place + 1` of a sequence. A transposed layer's kernel is its stride.
  MapLayer(torch::nn::Module& sequence, int place, std::int64_t in, std::int64_t out,
           std::int32_t kernel, std::int32_t stride, bool transposed);

  /// (B, in, H, W) to (B, out, H', W'), channels last in memory.
  at::Tensor forward(const at::Tensor& map) const;
  FoldedLayer folded() const;

  /// On active cells. A layer with `spread` activates every cell whose window holds an active one;
  /// the others keep theirs.
  sparse::SparseTensor forward(const sparse::SparseTensor& cells, bool spread) const;
  /// Transposed, to the cells of `target`.
  sparse::SparseTensor forward_to(const sparse::SparseTensor& cells,
                                  const sparse::SparseTensor& target) const;

 private:
  at::Tensor elements() const;
  at::Tensor finish(const sparse::Connection& connection, const at::Tensor& features) const;

  std::int32_t kernel_, stride_;
  bool transposed_;
  at::Tensor weight_;
  std::shared_ptr<sparse::BatchNorm> norm_;
};

/// The 2-D backbone: blocks of convolutions at falling resolution, each brought back to the first
/// one's and put side by side.
class BirdsEyeBackbone : public torch::nn::Module {
 public:
  BirdsEyeBackbone(const BirdsEyeOptions& options, std::int64_t in_channels);

  /// Without gradients, float32 maps go through a MapPlan that is kept for the next one.
  at::Tensor forward(const at::Tensor& map) const;
  /// The first layer of each block spreads to the neighbours of active cells.
  sparse::SparseTensor forward(const sparse::SparseTensor& cells) const;

 private:
  std::shared_ptr<const MapPlan> plan_for(const at::Tensor& map) const;

  std::vector<std::vector<MapLayer>> blocks_;
  std::vector<MapLayer> up_;
  mutable std::mutex plan_mutex_;
  mutable std::shared_ptr<const MapPlan> plan_;  // until parameters, threads or the shape change
  mutable std::uint64_t plan_version_ = 0;
  mutable int plan_threads_ = 0;
};

/// The cells of a grid-bounded tensor as a map (B, C * Z, Y, X), channel c * Z + z, channels last
/// in memory.
at::Tensor to_map(const sparse::SparseTensor& cells);

}  // namespace arbox::detectors::pv_rcnn::internal
