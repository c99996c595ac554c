#pragma once

#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include <memory>
#include <span>
#include <vector>

#include "arbox/sparse/layers.h"
#include "arbox/sparse/point_search.h"

namespace arbox::sparse {

/// One radius of a set abstraction: its ball and the widths of its layers.
struct AbstractionScale {
  float radius = 0.8f;  ///< metres
  std::int32_t samples = 16;
  std::vector<std::int64_t> widths = {16, 16};
};

/// Features of points gathered around centres (PointNet++, PV-RCNN): for each radius the points of
/// a ball, each as (position relative to the centre, features), go through a shared network of
/// linear - batch norm - ReLU layers, and the largest value over the ball is kept. A centre without
/// neighbour counts as one all-zero input.
///
/// The first layer is linear before its norm: it runs once a source point, not once a neighbour.
/// Without gradients in eval mode the whole chain is one pass over each ball with the norms folded.
/// Parameters mlps.{radius}.{3 i}.weight (out, in, 1, 1) and mlps.{radius}.{3 i + 1} (batch norm)
/// for layer i; input columns are x, y, z, then the features.
class SetAbstraction : public torch::nn::Module {
 public:
  /// in_channels: columns of the features (0 for positions alone).
  /// Throws InvalidArgument for no scale, no width, or numbers that are not above zero.
  SetAbstraction(std::int64_t in_channels, std::vector<AbstractionScale> scales,
                 double epsilon = 1e-5);

  struct Input {
    at::Tensor points;    ///< (N, 3)
    at::Tensor features;  ///< (N, in_channels); may be undefined if in_channels is 0
    at::Tensor centres;   ///< (M, 3)
    std::span<const std::int64_t> point_counts = {};   ///< as in ball_query
    std::span<const std::int64_t> centre_counts = {};  ///< as in ball_query
  };
  /// (M, out_channels()): the scales' results side by side. Gradients reach features and
  /// parameters, not positions.
  at::Tensor forward(const Input& input);

  std::int64_t out_channels() const;

 private:
  struct Layer {
    at::Tensor weight;  // (out, in, 1, 1)
    std::shared_ptr<BatchNorm> norm;
  };

  at::Tensor differentiable(const Input& input, const std::vector<Layer>& layers,
                            const at::Tensor& index) const;
  at::Tensor folded(const Input& input, const std::vector<Layer>& layers,
                    const at::Tensor& index) const;

  std::int64_t in_channels_;
  std::vector<AbstractionScale> scales_;
  std::vector<std::vector<Layer>> layers_;
};

}  // namespace arbox::sparse
