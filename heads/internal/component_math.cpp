#include "arbox/heads/internal/component_math.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/atan2.h>
#include <ATen/ops/cos.h>
#include <ATen/ops/logsumexp.h>
#include <ATen/ops/sin.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/tensor.h>

#include <limits>
#include <numbers>
#include <vector>

#include "arbox/heads/internal/rotation_tensor.h"

namespace arbox::heads::internal {
namespace {

using at::Tensor;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

double period(const Component& component) { return component.high - component.low; }

Tensor direction(const Tensor& cosine, const Tensor& sine, const Component& component) {
  const Tensor angle = at::atan2(sine, cosine) * (period(component) / kTurn);
  return wrap(angle, component.low, period(component));
}

template <class Number>
Tensor by_component(std::span<const Component> components, at::ScalarType type, Number number) {
  std::vector<double> values;
  for (const Component& component : components) values.push_back(number(component));
  return at::tensor(values, at::kDouble).to(type);
}

}  // namespace

std::int64_t usable_bins(const Component& component, CircularEnds ends) {
  return component.bins - (component.circular && ends == CircularEnds::kMerged ? 1 : 0);
}

Tensor bin_values(const Component& component, std::int64_t bins, at::ScalarType type) {
  return (at::arange(bins, at::kDouble) * component.step() + component.low).to(type);
}

Tensor expected_value(const Tensor& probability, const Component& component) {
  const Tensor values = bin_values(component, probability.size(-1), probability.scalar_type());
  if (!component.circular) return (probability * values).sum(-1);
  const Tensor angle = values * (kTurn / period(component));
  return direction((probability * at::cos(angle)).sum(-1), (probability * at::sin(angle)).sum(-1),
                   component);
}

Tensor component_difference(const Tensor& first, const Tensor& second,
                            std::span<const Component> components) {
  const Tensor difference = first - second;
  std::vector<Tensor> columns;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const Component& component = components[i];
    const Tensor column = difference.select(-1, static_cast<std::int64_t>(i));
    columns.push_back(component.circular ? wrap(column, -0.5 * period(component), period(component))
                                         : column);
  }
  return at::stack(columns, -1);
}

Tensor mean_of_values(const Tensor& values, std::span<const Component> components) {
  std::vector<Tensor> columns;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const Component& component = components[i];
    const Tensor column = values.select(-1, static_cast<std::int64_t>(i));
    if (component.circular) {
      const Tensor angle = column * (kTurn / period(component));
      columns.push_back(direction(at::cos(angle).sum(-1), at::sin(angle).sum(-1), component));
    } else {
      columns.push_back(column.mean(-1));
    }
  }
  return at::stack(columns, -1);
}

Tensor middles(std::span<const Component> components, at::ScalarType type) {
  return by_component(components, type,
                      [](const Component& one) { return 0.5 * (one.low + one.high); });
}

Tensor half_ranges(std::span<const Component> components, at::ScalarType type) {
  return by_component(components, type, [](const Component& one) { return 0.5 * period(one); });
}

Tensor distinct_vectors(const Tensor& bins, const Tensor& mask) {
  if (bins.size(1) < 2) return mask;
  const Tensor equal = (bins.unsqueeze(1) == bins.unsqueeze(2)).all(-1);
  const Tensor earlier = equal.logical_and(mask.unsqueeze(1)).tril(-1).any(-1);
  return mask.logical_and(earlier.logical_not());
}

Tensor masked_mean(const Tensor& values, const Tensor& mask) {
  const Tensor weight = mask.to(values.scalar_type());
  return (values * weight).sum(1) / weight.sum(1);
}

Tensor masked_least(const Tensor& values, const Tensor& mask) {
  return values.masked_fill(mask.logical_not(), kUnbounded).amin(1);
}

Tensor masked_log_sum(const Tensor& values, const Tensor& mask) {
  return at::logsumexp(values.masked_fill(mask.logical_not(), -kUnbounded), 1);
}

Tensor size_values(const Tensor& sizes, const BoxCodec& codec, const References& references) {
  return codec.encode_sizes(sizes.to(references.size.scalar_type()).unsqueeze(1), references)
      .select(1, 0);
}

Tensor with_sizes(const Tensor& values, const BoxCodec& codec, const Tensor& sizes) {
  std::vector<Tensor> columns = values.unbind(-1);
  std::int64_t axis = 0;
  for (const int i : codec.size_components()) {
    Tensor& column = columns[static_cast<std::size_t>(i)];
    column = sizes.select(1, axis++).unsqueeze(1).expand_as(column);
  }
  return at::stack(columns, -1);
}

Tensor of_sizes(const Tensor& values, const Tensor& mask, const BoxCodec& codec,
                const Tensor& sizes) {
  Tensor fits = mask;
  std::int64_t axis = 0;
  for (const int i : codec.size_components()) {
    const double half_step = 0.5 * codec.components()[static_cast<std::size_t>(i)].step();
    const Tensor off = values.select(-1, i) - sizes.select(1, axis++).unsqueeze(1);
    fits = fits.logical_and(off.abs() <= half_step);
  }
  return fits;
}

}  // namespace arbox::heads::internal
