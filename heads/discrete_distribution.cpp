#include "arbox/heads/discrete_distribution.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/softmax.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/component_math.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr std::uint32_t kPurpose = 300;  // and one for each further component

/// (N, count) bins of draws from probabilities (N, bins).
Tensor draw_bins(const Tensor& probability, const Streams& streams, std::int64_t count,
                 std::uint32_t component) {
  const Tensor cumulative = probability.to(at::kDouble).cumsum(-1).contiguous();
  const Tensor ids = streams.object_ids.contiguous();
  const std::int64_t bins = cumulative.size(1);
  Tensor result = at::empty({cumulative.size(0), count}, at::kLong);
  for (std::int64_t n = 0; n < cumulative.size(0); ++n) {
    const double* row = cumulative.data_ptr<double>() + n * bins;
    const RandomStream random(streams.seed,
                              static_cast<std::uint64_t>(ids.data_ptr<std::int64_t>()[n]),
                              kPurpose + component);
    for (std::int64_t k = 0; k < count; ++k) {
      const double target = random.uniform(static_cast<std::uint32_t>(k)) * row[bins - 1];
      result.data_ptr<std::int64_t>()[n * count + k] =
          std::min<std::int64_t>(std::upper_bound(row, row + bins, target) - row, bins - 1);
    }
  }
  return result;
}

}  // namespace

DiscreteDistribution::DiscreteDistribution(std::vector<Tensor> log_probability, CircularEnds ends,
                                           std::shared_ptr<const BoxCodec> codec,
                                           References references, Tensor sizes)
    : ends_(ends),
      codec_(std::move(codec)),
      references_(references.detached()),
      sizes_(std::move(sizes)) {
  for (const Tensor& one : log_probability) {
    log_probability_.push_back(one.detach().to(at::kFloat));
  }
}

bool DiscreteDistribution::is_known(int component) const {
  if (!sizes_.defined()) return false;
  const auto fixed = codec_->size_components();
  return std::find(fixed.begin(), fixed.end(), component) != fixed.end();
}

Tensor DiscreteDistribution::vector_density(const Tensor& bins) const {
  Tensor sum = at::zeros({bins.size(0), bins.size(1)});
  for (std::size_t i = 0; i < log_probability_.size(); ++i) {
    if (is_known(static_cast<int>(i))) continue;
    const Tensor bin = bins.select(-1, static_cast<std::int64_t>(i));
    sum = sum + log_probability_[i].gather(1, bin) - std::log(codec_->components()[i].step());
  }
  return sum;
}

Draws DiscreteDistribution::draws_of(const Tensor& bins) const {
  Draws draws;
  draws.components = dequantize(bins, codec_->components());
  if (sizes_.defined()) draws.components = internal::with_sizes(draws.components, *codec_, sizes_);
  draws.log_density = vector_density(bins);
  draws.boxes = codec_->decode(draws.components, references_);
  return draws;
}

Draws DiscreteDistribution::mode(int beam_width) const {
  require_beam_width(beam_width);
  Tensor score = at::zeros({size(), 1});
  Tensor bins = at::zeros({size(), 1, 0}, at::kLong);
  for (std::size_t i = 0; i < log_probability_.size(); ++i) {
    Tensor beam = at::zeros_like(score, at::kLong), bin = at::zeros_like(beam);
    if (!is_known(static_cast<int>(i))) {
      const Tensor joint = score.unsqueeze(2) + log_probability_[i].unsqueeze(1);
      const Tensor flat = joint.flatten(1);
      const auto [best, index] = flat.topk(std::min<std::int64_t>(beam_width, flat.size(1)), 1);
      score = best;
      beam = index.div(joint.size(2), "floor");
      bin = index.remainder(joint.size(2));
      bins = bins.gather(1, beam.unsqueeze(-1).expand({size(), beam.size(1), bins.size(2)}));
    }
    bins = at::cat({bins, bin.unsqueeze(-1)}, -1);
  }
  return draws_of(bins);
}

Draws DiscreteDistribution::sample(int count, const Streams& streams, double temperature) const {
  require_draws(count, streams, temperature, size());
  std::vector<Tensor> columns;
  for (std::size_t i = 0; i < log_probability_.size(); ++i) {
    columns.push_back(draw_bins(at::softmax(log_probability_[i] / temperature, -1), streams, count,
                                static_cast<std::uint32_t>(i)));
  }
  return draws_of(at::stack(columns, -1));
}

Tensor DiscreteDistribution::mean() const {
  std::vector<Tensor> columns;
  for (std::size_t i = 0; i < log_probability_.size(); ++i) {
    columns.push_back(internal::expected_value(log_probability_[i].exp(), codec_->components()[i]));
  }
  Tensor values = at::stack(columns, -1).unsqueeze(1);
  if (sizes_.defined()) values = internal::with_sizes(values, *codec_, sizes_);
  return codec_->decode(values, references_).select(1, 0);
}

Tensor DiscreteDistribution::log_density(const Tensor& boxes) const {
  require_boxes(boxes, "log_density");
  const auto components = codec_->components();
  const ComponentSet set = codec_->equivalents(boxes.detach().to(at::kFloat), references_);
  const Tensor bins = quantize(set.values, components, ends_);
  Tensor mask = internal::distinct_vectors(bins, set.mask);
  if (sizes_.defined()) mask = internal::of_sizes(set.values, mask, *codec_, sizes_);
  const Tensor outside = overflows(set.values, components);
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (is_known(static_cast<int>(i))) continue;
    mask = mask.logical_and(outside.select(-1, static_cast<std::int64_t>(i)).logical_not());
  }
  return internal::masked_log_sum(vector_density(bins), mask);
}

std::unique_ptr<BoxDistribution> DiscreteDistribution::select(const Tensor& index) const {
  std::vector<Tensor> rows;
  for (const Tensor& one : log_probability_) rows.push_back(one.index_select(0, index));
  return std::make_unique<DiscreteDistribution>(
      std::move(rows), ends_, codec_, references_.select(index),
      sizes_.defined() ? sizes_.index_select(0, index) : sizes_);
}

std::unique_ptr<BoxDistribution> DiscreteDistribution::given_sizes(const Tensor& sizes) const {
  if (codec_->size_components().size() != 3) {
    throw NotAvailable("given_sizes: this codec does not describe all three sizes");
  }
  require_sizes(sizes, size());
  return std::make_unique<DiscreteDistribution>(log_probability_, ends_, codec_, references_,
                                                internal::size_values(sizes, *codec_, references_));
}

}  // namespace arbox::heads
