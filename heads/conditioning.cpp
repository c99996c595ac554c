#include "arbox/heads/conditioning.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/full.h>
#include <ATen/ops/tensor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/heads/internal/finite_boxes.h"
#include "arbox/heads/internal/same_box.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void require_extents(const Eigen::Vector3d& extents, const char* where, const std::string& name) {
  if (extents.allFinite() && (extents.array() > 0).all()) return;
  throw InvalidArgument(std::string(where) + ": expected finite extents above zero for " + name +
                        ", got " + std::to_string(extents.x()) + " x " +
                        std::to_string(extents.y()) + " x " + std::to_string(extents.z()));
}

std::array<double, 3> sorted(const Eigen::Vector3d& extents) {
  std::array<double, 3> sides{extents.x(), extents.y(), extents.z()};
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Every distinct order of the extents.
std::vector<Eigen::Vector3d> orders_of(const Eigen::Vector3d& extents) {
  std::vector<Eigen::Vector3d> orders;
  auto sides = sorted(extents);
  do {
    orders.emplace_back(sides[0], sides[1], sides[2]);
  } while (std::next_permutation(sides.begin(), sides.end()));
  return orders;
}

/// (objects, 3): the same size for all.
Tensor size_rows(const Eigen::Vector3d& size, std::int64_t objects) {
  return at::tensor({size.x(), size.y(), size.z()}, at::kDouble).expand({objects, 3});
}

/// The boxes of the orders of one known size, object by object.
std::vector<std::vector<internal::WeighedBox>> beams_of(const BoxDistribution& distribution,
                                                        const KnownSize& known,
                                                        const ConditioningOptions& options) {
  std::vector<std::vector<internal::WeighedBox>> beams(distribution.size());
  const auto orders = options.orders == "any" ? orders_of(known.size) : std::vector{known.size};
  const double each_order = -std::log(static_cast<double>(orders.size()));
  for (const Eigen::Vector3d& order : orders) {
    const Tensor sizes = size_rows(order, distribution.size());
    const Draws mode = distribution.given_sizes(sizes)->mode(
        {.beam_width = options.beam_width, .smoothing = options.smoothing});
    const Tensor score = mode.log_density.to(at::kDouble) +
                         (options.score == "joint"
                              ? distribution.log_size_density(sizes).to(at::kDouble).unsqueeze(1)
                              : at::full({distribution.size(), 1}, each_order, at::kDouble));
    const auto density = score.accessor<double, 2>();
    for (std::int64_t object = 0; object < distribution.size(); ++object) {
      const internal::FiniteBoxes found = internal::finite_boxes(mode.boxes[object]);
      for (std::size_t i = 0; i < found.boxes.size(); ++i) {
        const double one = density[object][found.rows[i]];
        if (one > -kInfinity) beams[object].push_back({found.boxes[i], one});
      }
    }
  }
  return beams;
}

/// Index of the largest, and its lead over the largest that `rival` accepts.
template <class Rival>
std::pair<std::size_t, double> lead(const std::vector<double>& values, const Rival& rival) {
  const std::size_t best = std::max_element(values.begin(), values.end()) - values.begin();
  double next = -kInfinity;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i != best && rival(best, i)) next = std::max(next, values[i]);
  }
  return {best, next == -kInfinity ? kInfinity : values[best] - next};
}

}  // namespace

std::vector<ConditionedBox> given_known_sizes(const BoxDistribution& distribution,
                                              std::span<const KnownSize> known,
                                              const ConditioningOptions& options) {
  validate_options(options, "conditioning");
  if (known.empty()) throw InvalidArgument("given_known_sizes: expected at least one known size");
  for (const KnownSize& one : known) {
    require_extents(one.size, "given_known_sizes", "'" + one.name + "'");
  }
  std::vector<ConditionedBox> result(distribution.size());
  for (const KnownSize& one : known) {
    const auto beams = beams_of(distribution, one, options);
    for (std::size_t object = 0; object < result.size(); ++object) {
      const auto boxes = internal::merged(beams[object], options.same_box);
      result[object].by_size.push_back(
          boxes.empty() ? SizedBox{{}, -kInfinity}
                        : SizedBox{boxes.front().box, boxes.front().log_density});
    }
  }
  for (ConditionedBox& one : result) {
    std::vector<double> densities;
    for (const SizedBox& sized : one.by_size) densities.push_back(sized.log_density);
    std::tie(one.known_size, one.margin) = lead(densities, [](auto, auto) { return true; });
    one.box = one.by_size[one.known_size].box;
    one.log_density = densities[one.known_size];
  }
  return result;
}

std::string why_not_conditioned(const BoxDistribution& distribution) {
  if (distribution.measure() == Measure::kNone) {
    return "this head predicts one box and does not know how likely a size is";
  }
  try {
    const Tensor sizes = size_rows(Eigen::Vector3d::Ones(), distribution.size());
    distribution.given_sizes(sizes);
    distribution.log_size_density(sizes);
  } catch (const NotAvailable& error) {
    return error.what();
  }
  return {};
}

std::vector<double> log_density_of_size(const BoxDistribution& distribution,
                                        const Eigen::Vector3d& extents) {
  require_extents(extents, "log_density_of_size", "a size");
  std::vector<double> result(distribution.size(), -kInfinity);
  for (const Eigen::Vector3d& order : orders_of(extents)) {
    const Tensor density =
        distribution.log_size_density(size_rows(order, distribution.size())).to(at::kDouble);
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] =
          internal::log_sum(result[i], density[static_cast<std::int64_t>(i)].item<double>());
    }
  }
  return result;
}

CommonSize common_size(const BoxDistribution& distribution,
                       std::span<const Eigen::Vector3d> candidates) {
  if (candidates.empty()) throw InvalidArgument("common_size: expected at least one candidate");
  CommonSize result;
  for (const Eigen::Vector3d& candidate : candidates) {
    double sum = 0.0;
    for (const double one : log_density_of_size(distribution, candidate)) sum += one;
    result.log_densities.push_back(sum);
  }
  std::tie(result.candidate, result.margin) =
      lead(result.log_densities, [&](std::size_t best, std::size_t i) {
        return sorted(candidates[best]) != sorted(candidates[i]);
      });
  return result;
}

std::vector<Eigen::Vector3d> draw_sizes(const BoxDistribution& distribution, int count,
                                        const Streams& streams) {
  const Draws draws = distribution.sample(count, streams);
  std::vector<Eigen::Vector3d> sizes;
  for (const auto& box : internal::finite_boxes(draws.boxes.flatten(0, 1)).boxes) {
    sizes.push_back(box.size);
  }
  return sizes;
}

}  // namespace arbox::heads
