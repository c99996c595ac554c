#include "arbox/detectors/pv_rcnn/internal/row_layer.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/dropout.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/relu.h>

#include <cmath>

namespace arbox::detectors::pv_rcnn::internal {
namespace {

std::vector<std::int64_t> weight_shape(std::int64_t out, std::int64_t in, int ones) {
  std::vector<std::int64_t> shape = {out, in};
  shape.resize(2 + ones, 1);
  return shape;
}

}  // namespace

at::Tensor initial_weight(std::vector<std::int64_t> shape, std::int64_t fan_in) {
  const double bound = 1.0 / std::sqrt(static_cast<double>(fan_in));
  return at::empty(shape, at::kFloat).uniform_(-bound, bound);
}

std::shared_ptr<torch::nn::Module> add_child(torch::nn::Module& parent, const std::string& name) {
  return parent.register_module(name, std::make_shared<torch::nn::Module>());
}

RowLayer::RowLayer(torch::nn::Module& sequence, int place, std::int64_t in, std::int64_t out,
                   int ones)
    : weight_(add_child(sequence, std::to_string(place))
                  ->register_parameter("weight", initial_weight(weight_shape(out, in, ones), in))),
      norm_(sequence.register_module(std::to_string(place + 1),
                                     std::make_shared<sparse::BatchNorm>(out))) {}

at::Tensor RowLayer::forward(const at::Tensor& rows) const {
  const at::Tensor linear = at::linear(rows, weight_.flatten(1));
  if (!sparse::folds(*norm_)) return at::relu(norm_->forward(linear));
  const auto [scale, shift] = norm_->folded();
  return linear.mul_(scale).add_(shift).relu_();
}

RowNetwork::RowNetwork(torch::nn::Module& sequence, Shape shape) : shape_(std::move(shape)) {
  int place = 0;
  std::int64_t in = shape_.in;
  for (std::size_t i = 0; i < shape_.hidden.size(); ++i) {
    layers_.emplace_back(sequence, place, in, shape_.hidden[i], shape_.ones);
    in = shape_.hidden[i];
    place += drops_after(i) ? 4 : 3;
  }
  if (shape_.out == 0) return;
  const auto last = add_child(sequence, std::to_string(place));
  weight_ = last->register_parameter("weight",
                                     initial_weight(weight_shape(shape_.out, in, shape_.ones), in));
  bias_ = last->register_parameter("bias", initial_weight({shape_.out}, in));
}

bool RowNetwork::drops_after(std::size_t layer) const {
  if (shape_.places == Dropout::kBetween) return layer + 1 < shape_.hidden.size();
  return shape_.places == Dropout::kAfterFirst && layer == 0;
}

at::Tensor RowNetwork::forward(at::Tensor rows) const {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    rows = layers_[i].forward(rows);
    if (drops_after(i)) rows = at::dropout(rows, shape_.dropout, layers_[i].is_training());
  }
  return shape_.out == 0 ? rows : at::linear(rows, weight_.flatten(1), bias_);
}

}  // namespace arbox::detectors::pv_rcnn::internal
