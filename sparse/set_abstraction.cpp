#include "arbox/sparse/set_abstraction.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/relu.h>
#include <ATen/ops/zeros.h>

#include <cmath>
#include <string>

#include "arbox/base/error.h"
#include "arbox/sparse/internal/abstraction.h"
#include "arbox/sparse/point_sets.h"

namespace arbox::sparse {
namespace {

/// (out, in, 1, 1) as (in, out).
at::Tensor as_matrix(const at::Tensor& weight) { return weight.flatten(1).t(); }

}  // namespace

SetAbstraction::SetAbstraction(std::int64_t in_channels, std::vector<AbstractionScale> scales,
                               double epsilon)
    : in_channels_(in_channels), scales_(std::move(scales)) {
  if (in_channels < 0 || scales_.empty()) {
    throw InvalidArgument("SetAbstraction: expected at least one scale and in_channels >= 0");
  }
  const auto mlps = register_module("mlps", std::make_shared<torch::nn::Module>());
  for (std::size_t s = 0; s < scales_.size(); ++s) {
    const auto mlp =
        mlps->register_module(std::to_string(s), std::make_shared<torch::nn::Module>());
    std::int64_t channels = in_channels + 3;
    std::vector<Layer>& layers = layers_.emplace_back();
    for (const std::int64_t width : scales_[s].widths) {
      if (width < 1) throw InvalidArgument("SetAbstraction: a layer has at least one channel");
      const std::size_t at = 3 * layers.size();
      const auto linear =
          mlp->register_module(std::to_string(at), std::make_shared<torch::nn::Module>());
      const at::Tensor weight =
          linear->register_parameter("weight", at::randn({width, channels, 1, 1}) *
                                                   std::sqrt(2.0 / static_cast<double>(channels)));
      const auto norm =
          mlp->register_module(std::to_string(at + 1), std::make_shared<BatchNorm>(width, epsilon));
      layers.push_back({weight, norm});
      channels = width;
    }
    if (layers.empty()) throw InvalidArgument("SetAbstraction: a scale has at least one layer");
  }
}

std::int64_t SetAbstraction::out_channels() const {
  std::int64_t sum = 0;
  for (const AbstractionScale& scale : scales_) sum += scale.widths.back();
  return sum;
}

at::Tensor SetAbstraction::forward(const Input& input) {
  const std::int64_t columns = input.features.defined() ? input.features.size(1) : 0;
  if (columns != in_channels_ ||
      (input.features.defined() && input.features.size(0) != input.points.size(0))) {
    throw InvalidArgument("SetAbstraction: expected features (N, " + std::to_string(in_channels_) +
                          "), one row a point");
  }
  const bool one_pass = folds(*this) && input.points.is_cpu() &&
                        input.points.scalar_type() == at::kFloat &&
                        layers_.front().front().weight.scalar_type() == at::kFloat;
  std::vector<at::Tensor> results;
  for (std::size_t s = 0; s < scales_.size(); ++s) {
    const at::Tensor index = ball_query(
        input.points, input.centres, {.radius = scales_[s].radius, .samples = scales_[s].samples},
        input.point_counts, input.centre_counts);
    results.push_back(one_pass ? folded(input, layers_[s], index)
                               : differentiable(input, layers_[s], index));
  }
  return at::cat(results, 1);
}

at::Tensor SetAbstraction::differentiable(const Input& input, const std::vector<Layer>& layers,
                                          const at::Tensor& index) const {
  const at::Tensor weight = as_matrix(layers[0].weight);
  const at::Tensor points = input.points.to(weight.scalar_type()).detach();
  const at::Tensor centres = input.centres.to(weight.scalar_type()).detach();
  const at::Tensor present = (index >= 0).to(weight.scalar_type()).unsqueeze(-1);
  const at::Tensor relative = (group(points, index) - centres.unsqueeze(1)) * present;
  at::Tensor rows = at::matmul(relative, weight.slice(0, 0, 3));
  if (in_channels_ > 0) {
    rows = rows + group(at::matmul(input.features, weight.slice(0, 3)), index);
  }
  const std::int64_t centre_count = index.size(0), samples = index.size(1);
  rows = rows.flatten(0, 1);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (i > 0) rows = at::matmul(rows, as_matrix(layers[i].weight));
    rows = at::relu(layers[i].norm->forward(rows));
  }
  return rows.view({centre_count, samples, layers.back().weight.size(0)}).amax(1);
}

at::Tensor SetAbstraction::folded(const Input& input, const std::vector<Layer>& layers,
                                  const at::Tensor& index) const {
  const auto first = layers[0].norm->folded();
  const at::Tensor weight = (as_matrix(layers[0].weight) * first.scale).contiguous();
  const at::Tensor points = input.points.contiguous(), centres = input.centres.contiguous();
  const at::Tensor projected = in_channels_ > 0
                                   ? at::matmul(input.features, weight.slice(0, 3)).contiguous()
                                   : at::zeros({points.size(0), weight.size(1)}, weight.options());
  std::vector<at::Tensor> kept;
  internal::AbstractionProblem problem{.points = points.data_ptr<float>(),
                                       .centres = centres.data_ptr<float>(),
                                       .index = index.data_ptr<std::int64_t>(),
                                       .centre_count = index.size(0),
                                       .samples = static_cast<std::int32_t>(index.size(1)),
                                       .projected = projected.data_ptr<float>(),
                                       .position_weight = weight.data_ptr<float>(),
                                       .first_shift = first.shift.data_ptr<float>(),
                                       .width = static_cast<std::int32_t>(weight.size(1)),
                                       .layers = {}};
  for (std::size_t i = 1; i < layers.size(); ++i) {
    const auto norm = layers[i].norm->folded();
    kept.push_back((as_matrix(layers[i].weight) * norm.scale).contiguous());
    kept.push_back(norm.shift);
    problem.layers.push_back({kept[kept.size() - 2].data_ptr<float>(),
                              kept.back().data_ptr<float>(),
                              static_cast<std::int32_t>(layers[i].weight.size(1)),
                              static_cast<std::int32_t>(layers[i].weight.size(0))});
  }
  at::Tensor result = at::empty({index.size(0), layers.back().weight.size(0)}, weight.options());
  internal::abstract_balls(problem, result.data_ptr<float>());
  return result;
}

}  // namespace arbox::sparse
