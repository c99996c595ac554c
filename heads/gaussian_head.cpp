#include "arbox/heads/gaussian_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/exp.h>
#include <ATen/ops/sigmoid.h>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/heads/gaussian_distribution.h"
#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/multilayer_perceptron.h"

namespace arbox::heads {

using at::Tensor;

GaussianHead::GaussianHead(GaussianOptions options, HeadContext context)
    : options_(std::move(options)), context_(std::move(context)) {
  validate_options(options_, "gaussian head");
  if (options_.log_variance_low >= options_.log_variance_high) {
    throw ConfigError("gaussian head: log_variance_low must be below log_variance_high");
  }
  layers_ = register_module(
      "layers", std::make_shared<MultilayerPerceptron>(
                    context_.features + context_.condition, options_.hidden,
                    2 * static_cast<std::int64_t>(context_.codec->components().size())));
}

namespace {

/// Follows x near the middle of [low, high] and approaches the ends.
Tensor soft_clamp(const Tensor& x, double low, double high) {
  const double range = high - low, middle = 0.5 * (low + high);
  return low + range * at::sigmoid((x - middle) * (4.0 / range));
}

}  // namespace

std::pair<Tensor, Tensor> GaussianHead::predict(const HeadInput& input) const {
  const auto components = context_.codec->components();
  const auto width = static_cast<std::int64_t>(components.size());
  const Tensor raw = layers_->forward(input.joined());
  const Tensor half = internal::half_ranges(components, raw.scalar_type());
  const Tensor log_variance =
      soft_clamp(raw.slice(1, width), options_.log_variance_low, options_.log_variance_high);
  return {internal::middles(components, raw.scalar_type()) + raw.slice(1, 0, width) * half,
          half * at::exp(0.5 * log_variance)};
}

std::unique_ptr<BoxDistribution> GaussianHead::forward(const HeadInput& input) {
  input.require_valid(context_, "gaussian head");
  const auto [mean, deviation] = predict(input);
  return std::make_unique<GaussianDistribution>(mean, deviation, context_.codec, input.references);
}

HeadLoss GaussianHead::loss(const HeadInput& input, const Tensor& target_boxes) {
  input.require_valid(context_, "gaussian head");
  require_targets(target_boxes, input.count(), "gaussian head");
  const auto components = context_.codec->components();
  const ComponentSet set =
      supervised_vectors(*context_.codec, target_boxes, input.references, options_.supervision);
  const auto [mean, deviation] = predict(input);
  const Tensor each =
      -gaussian_log_density(set.values.to(mean.scalar_type()), mean, deviation, components).sum(-1);
  const Tensor likelihood = reduce_vectors(each, set.mask, options_.supervision);
  return {likelihood *
              likelihood_scale(options_.reduction, options_.likelihood_weight, components.size()),
          {{"likelihood", likelihood}}};
}

}  // namespace arbox::heads
