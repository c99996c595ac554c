#include "arbox/heads/autoregressive_distribution.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/autoregressive_search.h"
#include "arbox/heads/internal/component_math.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr int kDrawsOfMean = 256;

Tensor tensor_of(const std::vector<float>& values, at::IntArrayRef shape) {
  Tensor result = at::empty(shape, at::kFloat);
  std::copy(values.begin(), values.end(), result.data_ptr<float>());
  return result;
}

internal::FeatureRows feature_rows(const Tensor& inputs) {
  return {inputs.data_ptr<float>(), inputs.size(0), static_cast<std::int32_t>(inputs.size(1))};
}

/// Log of the volume of a cell of the components.
double log_cell(std::span<const Component> components) {
  double sum = 0.0;
  for (const Component& one : components) sum += std::log(one.step());
  return sum;
}

internal::KnownPrefix known_prefix(const Tensor& known) {
  if (!known.defined()) return {};
  return {{known.data_ptr<float>(), static_cast<std::size_t>(known.numel())},
          static_cast<std::int32_t>(known.size(1))};
}

Draws draws_of(const internal::Vectors& vectors, const AutoregressiveModel& model,
               const References& references, std::int32_t known) {
  Draws draws;
  draws.components =
      tensor_of(vectors.values, {vectors.objects, vectors.count, vectors.components});
  draws.log_density = tensor_of(vectors.log_probability, {vectors.objects, vectors.count}) -
                      log_cell(model.codec().components().subspan(known));
  draws.boxes = model.codec().decode(draws.components, references);
  return draws;
}

}  // namespace

AutoregressiveDistribution::AutoregressiveDistribution(
    std::shared_ptr<const AutoregressiveModel> model, Tensor inputs, References references,
    Tensor known)
    : model_(std::move(model)),
      inputs_(inputs.detach().to(at::kFloat).contiguous()),
      references_(references.detached()),
      known_(known.defined() ? known.detach().to(at::kFloat).contiguous() : known) {}

std::int32_t AutoregressiveDistribution::known_count() const {
  return known_.defined() ? static_cast<std::int32_t>(known_.size(1)) : 0;
}

Draws AutoregressiveDistribution::mode(const ModeOptions& options) const {
  require_mode_options(options);
  const internal::PackedNetwork& network = model_->network();
  std::int64_t vectors = 1;
  for (std::int32_t i = known_count(); i < network.size(); ++i) {
    vectors = std::min<std::int64_t>(options.beam_width, vectors * network[i].bins);
  }
  return draws_of(internal::beam_search(
                      network, feature_rows(inputs_),
                      {.width = static_cast<std::int32_t>(vectors), .smoothing = options.smoothing},
                      known_prefix(known_), {.threads = model_->threads()}),
                  *model_, references_, known_count());
}

Draws AutoregressiveDistribution::sample(int count, const Streams& streams,
                                         double temperature) const {
  require_draws(count, streams, temperature, size());
  const Tensor ids = streams.object_ids.contiguous();
  return draws_of(
      internal::sample(model_->network(), feature_rows(inputs_),
                       {ids.data_ptr<std::int64_t>(), static_cast<std::size_t>(ids.numel())},
                       streams.seed, count, temperature, known_prefix(known_),
                       {.threads = model_->threads()}),
      *model_, references_, known_count());
}

Tensor AutoregressiveDistribution::mean() const {
  const Draws draws = sample(kDrawsOfMean, {0, at::zeros({size()}, at::kLong)}, 1.0);
  const Tensor mean = internal::mean_of_values(draws.components, model_->codec().components());
  return model_->codec().decode(mean.unsqueeze(1), references_).select(1, 0);
}

Tensor AutoregressiveDistribution::score(const Tensor& values, std::int32_t first,
                                         std::int32_t last) const {
  const Tensor rows = values.to(at::kFloat).contiguous();
  return tensor_of(
      internal::log_probability(model_->network(), feature_rows(inputs_),
                                {rows.data_ptr<float>(), static_cast<std::size_t>(rows.numel())},
                                static_cast<std::int32_t>(rows.size(1)), {first, last},
                                {.threads = model_->threads()}),
      {rows.size(0), rows.size(1)});
}

Tensor AutoregressiveDistribution::log_probability(const Tensor& values) const {
  return score(values, known_count(), model_->network().size());
}

Tensor AutoregressiveDistribution::log_density(const Tensor& boxes) const {
  require_boxes(boxes, "log_density");
  const auto components = model_->codec().components();
  const ComponentSet set = model_->codec().equivalents(boxes.detach().to(at::kFloat), references_);
  const Tensor bins = quantize(set.values, components, model_->circular_ends());
  Tensor outside = overflows(set.values, components);
  Tensor mask = internal::distinct_vectors(bins, set.mask);
  Tensor values = dequantize(bins, components);
  if (known_.defined()) {
    mask = internal::of_sizes(set.values, mask, model_->codec(), known_);
    values = internal::with_sizes(values, model_->codec(), known_);
    outside = outside.slice(-1, known_count());
  }
  mask = mask.logical_and(outside.any(-1).logical_not());
  return internal::masked_log_sum(log_probability(values), mask) -
         log_cell(components.subspan(known_count()));
}

std::unique_ptr<BoxDistribution> AutoregressiveDistribution::select(const Tensor& index) const {
  return std::make_unique<AutoregressiveDistribution>(
      model_, inputs_.index_select(0, index), references_.select(index),
      known_.defined() ? known_.index_select(0, index) : known_);
}

Tensor AutoregressiveDistribution::values_of_sizes(const Tensor& sizes, const char* where) const {
  if (model_->codec().size_components() != std::vector{0, 1, 2}) {
    throw NotAvailable(std::string(where) +
                       ": this model's codec does not predict the size first (order "
                       "size_center_rotation), so that the rest cannot be conditioned on it");
  }
  require_sizes(sizes, size());
  return internal::size_values(sizes, model_->codec(), references_);
}

std::unique_ptr<BoxDistribution> AutoregressiveDistribution::given_sizes(
    const Tensor& sizes) const {
  return std::make_unique<AutoregressiveDistribution>(model_, inputs_, references_,
                                                      values_of_sizes(sizes, "given_sizes"));
}

Tensor AutoregressiveDistribution::log_size_density(const Tensor& sizes) const {
  const Tensor values = values_of_sizes(sizes, "log_size_density");
  const auto components = model_->codec().components().first(3);
  const Tensor on_bins =
      dequantize(quantize(values, components, model_->circular_ends()), components);
  const Tensor rest = at::zeros({size(), model_->network().size() - 3}, at::kFloat);
  const Tensor density =
      score(at::cat({on_bins, rest}, 1).unsqueeze(1), 0, 3).select(1, 0) - log_cell(components);
  return density.masked_fill(overflows(values, components).any(-1),
                             -std::numeric_limits<double>::infinity());
}

}  // namespace arbox::heads
