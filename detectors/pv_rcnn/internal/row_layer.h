#pragma once

#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include <memory>
#include <string>
#include <vector>

#include "arbox/sparse/layers.h"

namespace arbox::detectors::pv_rcnn::internal {

/// Uniform within 1 / sqrt(fan_in), LibTorch's default for layers.
at::Tensor initial_weight(std::vector<std::int64_t> shape, std::int64_t fan_in);

/// A new child of `parent`, to be filled with parameters and children.
std::shared_ptr<torch::nn::Module> add_child(torch::nn::Module& parent, const std::string& name);

/// Linear without bias - batch norm - ReLU on rows. Children `place` (weight) and `place + 1`
/// (norm) of a sequence.
class RowLayer {
 public:
  /// The weight's shape is (out, in) followed by `ones` ones, as kernels of one element have.
  RowLayer(torch::nn::Module& sequence, int place, std::int64_t in, std::int64_t out, int ones = 0);

  /// (N, in) to (N, out).
  at::Tensor forward(const at::Tensor& rows) const;
  /// False for a layer in eval mode, such as a frozen one.
  bool is_training() const { return norm_->is_training(); }

 private:
  at::Tensor weight_;
  std::shared_ptr<sparse::BatchNorm> norm_;
};

/// Hidden RowLayers and a last linear layer with bias. Children of the sequence are numbered as
/// OpenPCDet does, who counts rectifiers and dropouts: 3 places a hidden layer, 4 with dropout.
class RowNetwork {
 public:
  /// After which hidden layers features are left out: none, the first, all but the last.
  enum class Dropout { kNowhere, kAfterFirst, kBetween };
  struct Shape {
    std::int64_t in;
    std::vector<std::int64_t> hidden;
    /// 0: no last layer.
    std::int64_t out = 0;
    int ones = 0;
    Dropout places = Dropout::kNowhere;
    double dropout = 0;  ///< Share that is left out.
  };

  RowNetwork(torch::nn::Module& sequence, Shape shape);
  /// Drops features behind layers that are training.
  at::Tensor forward(at::Tensor rows) const;

  /// Of the last layer: (out, in, 1...) and (out).
  const at::Tensor& last_weight() const { return weight_; }
  const at::Tensor& last_bias() const { return bias_; }

 private:
  bool drops_after(std::size_t layer) const;

  Shape shape_;
  std::vector<RowLayer> layers_;
  at::Tensor weight_, bias_;
};

}  // namespace arbox::detectors::pv_rcnn::internal
