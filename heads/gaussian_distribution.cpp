#include "arbox/heads/gaussian_distribution.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/log.h>
#include <ATen/ops/logsumexp.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/component_math.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr std::uint32_t kGaussianPurpose = 400;  // and one for each further component
constexpr std::int64_t kTurns = 4;

/// (N, count, D) standard normals.
Tensor standard_normals(const Streams& streams, std::int64_t count, std::int64_t width) {
  const Tensor ids = streams.object_ids.contiguous();
  Tensor result = at::empty({ids.size(0), count, width}, at::kFloat);
  float* number = result.data_ptr<float>();
  for (std::int64_t n = 0; n < ids.size(0); ++n) {
    const auto id = static_cast<std::uint64_t>(ids.data_ptr<std::int64_t>()[n]);
    for (std::int64_t k = 0; k < count; ++k) {
      for (std::int64_t i = 0; i < width; ++i) {
        *number++ = static_cast<float>(
            RandomStream(streams.seed, id, kGaussianPurpose + static_cast<std::uint32_t>(i))
                .normal(static_cast<std::uint32_t>(k)));
      }
    }
  }
  return result;
}

}  // namespace

Tensor gaussian_log_density(const Tensor& values, const Tensor& mean, const Tensor& deviation,
                            std::span<const Component> components) {
  static const double kLogRoot = 0.5 * std::log(2.0 * std::numbers::pi);
  const Tensor spread = deviation.unsqueeze(1);
  const Tensor difference = internal::component_difference(values, mean.unsqueeze(1), components);
  std::vector<Tensor> columns;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const auto column = static_cast<std::int64_t>(i);
    const Tensor sigma = spread.select(-1, column);
    Tensor z = difference.select(-1, column) / sigma;
    if (components[i].circular) {
      const double period = components[i].high - components[i].low;
      const Tensor turns = at::arange(-kTurns, kTurns + 1, values.options()) * period;
      z = z.unsqueeze(-1) + turns / sigma.unsqueeze(-1);
      columns.push_back(at::logsumexp(-0.5 * z.square(), -1) - at::log(sigma) - kLogRoot);
    } else {
      columns.push_back(-0.5 * z.square() - at::log(sigma) - kLogRoot);
    }
  }
  return at::stack(columns, -1);
}

GaussianDistribution::GaussianDistribution(const Tensor& mean, const Tensor& deviation,
                                           std::shared_ptr<const BoxCodec> codec,
                                           const References& references)
    : IndependentDistribution(std::move(codec), references),
      mean_(mean.detach().to(at::kFloat)),
      deviation_(deviation.detach().to(at::kFloat)) {}

std::unique_ptr<IndependentDistribution> GaussianDistribution::clone() const {
  return std::make_unique<GaussianDistribution>(*this);
}

void GaussianDistribution::keep_rows(const Tensor& index) {
  mean_ = mean_.index_select(0, index);
  deviation_ = deviation_.index_select(0, index);
}

Tensor GaussianDistribution::vector_density(const Tensor& values) const {
  Tensor each = gaussian_log_density(values, mean_, deviation_, codec().components());
  for (int i = 0; i < each.size(-1); ++i) {
    if (is_known(i)) each.select(-1, i).zero_();
  }
  return each.sum(-1);
}

Tensor GaussianDistribution::density_of(const Tensor& values, const std::vector<int>& of) const {
  const Tensor each = gaussian_log_density(values, mean_, deviation_, codec().components());
  Tensor sum = at::zeros({size()}, each.options());
  for (const int i : of) sum += each.select(1, 0).select(-1, i);
  return sum;
}

Draws GaussianDistribution::draws_of(const Tensor& values) const {
  std::vector<Tensor> columns = values.unbind(-1);
  const auto components = codec().components();
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (!components[i].circular) continue;
    const double period = components[i].high - components[i].low;
    columns[i] = columns[i] - period * ((columns[i] - components[i].low) / period).floor();
  }
  Draws draws;
  draws.components = with_known(at::stack(columns, -1));
  draws.log_density = vector_density(draws.components);
  draws.boxes = codec().decode(draws.components, references());
  return draws;
}

Draws GaussianDistribution::mode(const ModeOptions& options) const {
  require_mode_options(options);
  return draws_of(mean_.unsqueeze(1));
}

Draws GaussianDistribution::sample(int count, const Streams& streams, double temperature) const {
  require_draws(count, streams, temperature, size());
  const Tensor normals = standard_normals(streams, count, mean_.size(1));
  return draws_of(mean_.unsqueeze(1) + std::sqrt(temperature) * deviation_.unsqueeze(1) * normals);
}

Tensor GaussianDistribution::mean() const {
  return draws_of(mean_.unsqueeze(1)).boxes.select(1, 0);
}

Tensor GaussianDistribution::log_density(const Tensor& boxes) const {
  require_boxes(boxes, "log_density");
  const ComponentSet set = codec().equivalents(boxes.detach().to(at::kFloat), references());
  return internal::masked_log_sum(vector_density(set.values), of_known(set.values, set.mask));
}

}  // namespace arbox::heads
