#include "arbox/heads/pointwise_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/where.h>

#include <utility>

#include "arbox/base/options.h"
#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/multilayer_perceptron.h"
#include "arbox/heads/point_distribution.h"

namespace arbox::heads {

using at::Tensor;

Tensor point_loss(const Tensor& difference, PointLoss loss, double beta) {
  const Tensor distance = difference.abs();
  if (loss == PointLoss::kL1) return distance;
  return at::where(distance < beta, 0.5 / beta * distance.square(), distance - 0.5 * beta);
}

PointwiseHead::PointwiseHead(PointwiseOptions options, HeadContext context)
    : options_(std::move(options)), context_(std::move(context)) {
  validate_options(options_, "pointwise head");
  layers_ = register_module("layers",
                            std::make_shared<MultilayerPerceptron>(
                                context_.features + context_.condition, options_.hidden,
                                static_cast<std::int64_t>(context_.codec->components().size())));
}

Tensor PointwiseHead::components(const HeadInput& input) const {
  const auto described = context_.codec->components();
  const Tensor raw = layers_->forward(input.joined());
  return internal::middles(described, raw.scalar_type()) +
         raw * internal::half_ranges(described, raw.scalar_type());
}

std::unique_ptr<BoxDistribution> PointwiseHead::forward(const HeadInput& input) {
  input.require_valid(context_, "pointwise head");
  return std::make_unique<PointDistribution>(components(input), context_.codec, input.references);
}

HeadLoss PointwiseHead::loss(const HeadInput& input, const Tensor& target_boxes) {
  input.require_valid(context_, "pointwise head");
  require_targets(target_boxes, input.count(), "pointwise head");
  const auto described = context_.codec->components();
  const ComponentSet set =
      supervised_vectors(*context_.codec, target_boxes, input.references, options_.supervision);
  const Tensor predicted = components(input).unsqueeze(1);
  const Tensor difference = internal::component_difference(predicted, set.values, described) /
                            internal::half_ranges(described, predicted.scalar_type());
  const Tensor each = point_loss(difference, options_.loss, options_.beta).mean(-1);
  const Tensor loss = reduce_vectors(each, set.mask, options_.supervision);
  return {loss, {{"distance", loss}}};
}

}  // namespace arbox::heads
