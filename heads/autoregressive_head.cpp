#include "arbox/heads/autoregressive_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/log_softmax.h>
#include <ATen/ops/softmax.h>
#include <ATen/ops/stack.h>

#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/multilayer_perceptron.h"
#include "arbox/heads/rotated_iou.h"

namespace arbox::heads {

using at::Tensor;

AutoregressiveHead::AutoregressiveHead(AutoregressiveOptions options, HeadContext context)
    : options_(std::move(options)), context_(std::move(context)) {
  validate_options(options_, "autoregressive head");
  if (options_.iou_weight > 0 && !context_.codec->upright()) {
    throw ConfigError(
        "autoregressive head: iou_weight needs a codec whose boxes stand upright, expected "
        "residual or scaled");
  }
  const auto group = register_module("autoreg", std::make_shared<torch::nn::Module>());
  std::int64_t inputs = context_.features + context_.condition;
  for (const Component& component : context_.codec->components()) {
    conditionals_.push_back(group->register_module(
        std::to_string(conditionals_.size()),
        std::make_shared<MultilayerPerceptron>(inputs++, options_.hidden, component.bins)));
  }
}

Tensor AutoregressiveHead::conditional(std::int64_t component, const Tensor& inputs,
                                       const Tensor& previous) const {
  const Component& described = context_.codec->components()[component];
  return conditionals_[component]
      ->forward(inputs, previous)
      .slice(-1, 0, internal::usable_bins(described, options_.circular_ends));
}

namespace {

Tensor log_probability_of_bin(const Tensor& logits, const Tensor& bin) {
  return at::log_softmax(logits, -1).gather(-1, bin.unsqueeze(-1)).squeeze(-1);
}

}  // namespace

Tensor AutoregressiveHead::log_probability(const Tensor& inputs, const Tensor& values) const {
  const Tensor bins = quantize(values, context_.codec->components(), options_.circular_ends);
  std::vector<Tensor> terms;
  for (std::int64_t i = 0; i < values.size(-1); ++i) {
    terms.push_back(
        log_probability_of_bin(conditional(i, inputs, values.slice(-1, 0, i)), bins.select(-1, i)));
  }
  return at::stack(terms, -1).sum(-1);
}

Tensor AutoregressiveHead::likelihood_loss(const HeadInput& input, const Tensor& boxes) const {
  const auto components = context_.codec->components();
  const ComponentSet set =
      context_.codec->equivalents(boxes, input.references.detached(boxes.scalar_type()));
  const Tensor bins = quantize(set.values, components, options_.circular_ends);
  const Tensor values = dequantize(bins, components).to(input.features.scalar_type());
  const Tensor mask = internal::distinct_vectors(bins, set.mask);
  return -internal::masked_mean(log_probability(input.joined(), values), mask);
}

Tensor AutoregressiveHead::iou_loss(const HeadInput& input, const Tensor& boxes) const {
  const Tensor inputs = input.joined();
  const Tensor prefix = distribution(input)
                            ->sample(options_.iou_samples, input.streams(), 1.0)
                            .components.to(inputs.scalar_type());
  const auto components = context_.codec->components();
  std::vector<Tensor> expected;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const auto component = static_cast<std::int64_t>(i);
    const Tensor logits = conditional(component, inputs, prefix.slice(-1, 0, component));
    expected.push_back(internal::expected_value(at::softmax(logits, -1), components[i]));
  }
  const Tensor decoded = context_.codec->decode(at::stack(expected, -1), input.references);
  const Tensor targets = boxes.to(inputs.scalar_type()).unsqueeze(1).expand_as(decoded);
  return (1 - rotated_iou(upright_boxes(decoded), upright_boxes(targets))).mean(1);
}

HeadLoss AutoregressiveHead::loss(const HeadInput& input, const Tensor& target_boxes) {
  input.require_valid(context_, "autoregressive head");
  require_targets(target_boxes, input.count(), "autoregressive head");
  HeadLoss result;
  const Tensor likelihood = likelihood_loss(input, target_boxes);
  result.terms["likelihood"] = likelihood;
  result.per_object = likelihood * likelihood_scale(options_.reduction, options_.likelihood_weight,
                                                    context_.codec->components().size());
  if (options_.iou_weight > 0) {
    const Tensor iou = iou_loss(input, target_boxes);
    result.terms["iou"] = iou;
    result.per_object = result.per_object + options_.iou_weight * iou;
  }
  return result;
}

std::unique_ptr<AutoregressiveDistribution> AutoregressiveHead::distribution(
    const HeadInput& input) const {
  std::vector<AutoregressiveModel::Layers> components;
  for (const auto& conditional : conditionals_) {
    auto& layers = components.emplace_back();
    for (const auto& layer : conditional->layers()) layers.push_back({layer.weight, layer.bias});
  }
  const std::scoped_lock lock(model_mutex_);
  if (!model_ || !model_->is_of(components)) {
    model_ = std::make_shared<const AutoregressiveModel>(
        context_.codec, options_.circular_ends, std::move(components), kLeak, options_.threads);
  }
  return std::make_unique<AutoregressiveDistribution>(model_, input.joined(), input.references);
}

std::unique_ptr<BoxDistribution> AutoregressiveHead::forward(const HeadInput& input) {
  input.require_valid(context_, "autoregressive head");
  return distribution(input);
}

}  // namespace arbox::heads
