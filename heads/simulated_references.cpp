#include <ATen/core/Tensor.h>

#include <cmath>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"
#include "arbox/geometry/rotation.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/fit_ranges.h"

namespace arbox::heads {
namespace {

using geometry::Box;

constexpr std::uint32_t kReferencePurpose = 500;

/// A reference as a box: its frame and its size.
Box region_of_interest(const Box& label, const RandomStream& random) {
  constexpr double kSpread = 0.1, kLeastIou = 0.55;
  constexpr std::uint32_t kTries = 100, kNumbers = 7;
  const Eigen::Matrix3d axes = geometry::Quaternion(label.rotation).toRotationMatrix();
  for (std::uint32_t attempt = 0; attempt < kTries; ++attempt) {
    const auto normal = [&](std::uint32_t i) {
      return kSpread * random.normal(attempt * kNumbers + i);
    };
    const Eigen::Vector3d shift(normal(0), normal(1), normal(2));
    const Eigen::Vector3d growth(std::exp(normal(3)), std::exp(normal(4)), std::exp(normal(5)));
    const Box region =
        geometry::make_yaw_box(label.center + axes * shift.cwiseProduct(label.size),
                               growth.cwiseProduct(label.size), geometry::yaw(label) + normal(6));
    if (geometry::overlap(region, label) >= kLeastIou) return region;
  }
  return geometry::make_yaw_box(label.center, label.size, geometry::yaw(label));
}

Box location(const Box& label, const RandomStream& random) {
  const double scale = label.size.maxCoeff() * std::exp(0.1 * random.normal(0));
  const Eigen::Vector3d within(random.uniform(1, -0.25, 0.25), random.uniform(2, -0.25, 0.25),
                               random.uniform(3, -0.25, 0.25));
  return {label.center + geometry::Quaternion(label.rotation) * within.cwiseProduct(label.size),
          Eigen::Vector3d::Constant(scale), geometry::Quaternion::Identity()};
}

Box quartiles(const Box& label, const RandomStream& random) {
  const double extent = geometry::axis_aligned_hull(label).sizes().maxCoeff();
  const double scale = extent * random.uniform(0, 0.4, 0.8);
  const Eigen::Vector3d shift(random.normal(1), random.normal(2), random.normal(3));
  return {label.center + 0.1 * scale * shift, Eigen::Vector3d::Constant(scale),
          geometry::Quaternion::Identity()};
}

}  // namespace

References simulated_references(std::span<const Box> boxes, const std::string& kind, int draws,
                                std::uint64_t seed) {
  if (kind != "residual" && kind != "scaled" && kind != "quartile") {
    throw InvalidArgument("simulated_references: expected residual, scaled or quartile, got '" +
                          kind + "'");
  }
  if (draws < 1) throw InvalidArgument("simulated_references: expected at least one draw");
  std::vector<Box> frames(boxes.size() * static_cast<std::size_t>(draws));
  parallel_for(std::ssize(frames), 64, 0, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Box& label = boxes[static_cast<std::size_t>(i) % boxes.size()];
      const RandomStream random(seed, static_cast<std::uint64_t>(i), kReferencePurpose);
      frames[i] = kind == "residual" ? region_of_interest(label, random)
                  : kind == "scaled" ? location(label, random)
                                     : quartiles(label, random);
    }
  });
  const at::Tensor rows = to_tensor(frames, at::kDouble);
  return {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
}

}  // namespace arbox::heads
