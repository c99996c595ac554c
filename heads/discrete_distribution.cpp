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
#include <limits>
#include <utility>

#include "arbox/base/random.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/internal/row_smoother.h"

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

DiscreteDistribution::DiscreteDistribution(const std::vector<Tensor>& log_probability,
                                           CircularEnds ends, std::shared_ptr<const BoxCodec> codec,
                                           const References& references)
    : IndependentDistribution(std::move(codec), references), ends_(ends) {
  for (const Tensor& one : log_probability) {
    log_probability_.push_back(one.detach().to(at::kFloat));
  }
}

std::unique_ptr<IndependentDistribution> DiscreteDistribution::clone() const {
  return std::make_unique<DiscreteDistribution>(*this);
}

void DiscreteDistribution::keep_rows(const Tensor& index) {
  for (Tensor& one : log_probability_) one = one.index_select(0, index);
}

Tensor DiscreteDistribution::component_density(const Tensor& bins, int component) const {
  return log_probability_[component].gather(1, bins.select(-1, component)) -
         std::log(codec().components()[component].step());
}

Tensor DiscreteDistribution::vector_density(const Tensor& bins) const {
  Tensor sum = at::zeros({bins.size(0), bins.size(1)});
  for (int i = 0; i < std::ssize(log_probability_); ++i) {
    if (!is_known(i)) sum += component_density(bins, i);
  }
  return sum;
}

Tensor DiscreteDistribution::density_of(const Tensor& values, const std::vector<int>& of) const {
  const Tensor bins = quantize(values, codec().components(), ends_);
  const Tensor outside = overflows(values, codec().components());
  Tensor sum = at::zeros({size(), 1});
  for (const int i : of) {
    sum += component_density(bins, i);
    sum.masked_fill_(outside.select(-1, i), -std::numeric_limits<float>::infinity());
  }
  return sum.select(1, 0);
}

Draws DiscreteDistribution::draws_of(const Tensor& bins) const {
  Draws draws;
  draws.components = with_known(dequantize(bins, codec().components()));
  draws.log_density = vector_density(bins);
  draws.boxes = codec().decode(draws.components, references());
  return draws;
}

DiscreteDistribution DiscreteDistribution::smoothed(double standard_deviation) const {
  DiscreteDistribution result = *this;
  internal::RowSmoother smoother(standard_deviation);
  for (std::size_t i = 0; i < log_probability_.size(); ++i) {
    Tensor& rows = result.log_probability_[i];
    rows = rows.contiguous().clone();
    for (std::int64_t n = 0; n < rows.size(0); ++n) {
      smoother.smooth(
          {rows.data_ptr<float>() + n * rows.size(1), static_cast<std::size_t>(rows.size(1))},
          codec().components()[i].circular);
    }
  }
  return result;
}

Draws DiscreteDistribution::mode(const ModeOptions& options) const {
  require_mode_options(options);
  if (options.smoothing > 0.0) {
    return smoothed(options.smoothing).mode({.beam_width = options.beam_width});
  }
  Tensor score = at::zeros({size(), 1});
  Tensor bins = at::zeros({size(), 1, 0}, at::kLong);
  for (std::size_t i = 0; i < log_probability_.size(); ++i) {
    Tensor beam = at::zeros_like(score, at::kLong), bin = at::zeros_like(beam);
    if (!is_known(static_cast<int>(i))) {
      const Tensor joint = score.unsqueeze(2) + log_probability_[i].unsqueeze(1);
      const Tensor flat = joint.flatten(1);
      const auto [best, index] =
          flat.topk(std::min<std::int64_t>(options.beam_width, flat.size(1)), 1);
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
    columns.push_back(internal::expected_value(log_probability_[i].exp(), codec().components()[i]));
  }
  const Tensor values = with_known(at::stack(columns, -1).unsqueeze(1));
  return codec().decode(values, references()).select(1, 0);
}

Tensor DiscreteDistribution::log_density(const Tensor& boxes) const {
  require_boxes(boxes, "log_density");
  const auto components = codec().components();
  const ComponentSet set = codec().equivalents(boxes.detach().to(at::kFloat), references());
  const Tensor bins = quantize(set.values, components, ends_);
  Tensor mask = of_known(set.values, internal::distinct_vectors(bins, set.mask));
  const Tensor outside = overflows(set.values, components);
  for (int i = 0; i < std::ssize(components); ++i) {
    if (!is_known(i)) mask = mask.logical_and(outside.select(-1, i).logical_not());
  }
  return internal::masked_log_sum(vector_density(bins), mask);
}

}  // namespace arbox::heads
