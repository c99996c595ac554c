#include "arbox/heads/discrete_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/log_softmax.h>
#include <ATen/ops/stack.h>

#include <utility>

#include "arbox/base/options.h"
#include "arbox/heads/discrete_distribution.h"
#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/multilayer_perceptron.h"

namespace arbox::heads {

using at::Tensor;

DiscreteHead::DiscreteHead(DiscreteOptions options, HeadContext context)
    : options_(std::move(options)), context_(std::move(context)) {
  validate_options(options_, "discrete head");
  const auto group = register_module("components", std::make_shared<torch::nn::Module>());
  const std::int64_t inputs = context_.features + context_.condition;
  for (const Component& component : context_.codec->components()) {
    components_.push_back(group->register_module(
        std::to_string(components_.size()),
        std::make_shared<MultilayerPerceptron>(inputs, options_.hidden, component.bins)));
  }
}

std::vector<Tensor> DiscreteHead::log_probabilities(const HeadInput& input) const {
  const Tensor rows = input.joined();
  std::vector<Tensor> result;
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Component& described = context_.codec->components()[i];
    const std::int64_t bins = internal::usable_bins(described, options_.circular_ends);
    result.push_back(at::log_softmax(components_[i]->forward(rows).slice(1, 0, bins), -1));
  }
  return result;
}

std::unique_ptr<BoxDistribution> DiscreteHead::forward(const HeadInput& input) {
  input.require_valid(context_, "discrete head");
  return std::make_unique<DiscreteDistribution>(log_probabilities(input), options_.circular_ends,
                                                context_.codec, input.references);
}

HeadLoss DiscreteHead::loss(const HeadInput& input, const Tensor& target_boxes) {
  input.require_valid(context_, "discrete head");
  require_targets(target_boxes, input.count(), "discrete head");
  const auto components = context_.codec->components();
  const ComponentSet set =
      supervised_vectors(*context_.codec, target_boxes, input.references, options_.supervision);
  const Tensor bins = quantize(set.values, components, options_.circular_ends);
  const std::vector<Tensor> log_probability = log_probabilities(input);
  std::vector<Tensor> terms;
  for (std::size_t i = 0; i < components.size(); ++i) {
    terms.push_back(log_probability[i].gather(1, bins.select(-1, static_cast<std::int64_t>(i))));
  }
  const Tensor likelihood =
      reduce_vectors(-at::stack(terms, -1).sum(-1), internal::distinct_vectors(bins, set.mask),
                     options_.supervision);
  return {likelihood *
              likelihood_scale(options_.reduction, options_.likelihood_weight, components.size()),
          {{"likelihood", likelihood}}};
}

}  // namespace arbox::heads
