#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/rotation.h"

/// \file
/// Made-up distributions over boxes for tests and benchmarks.

namespace arbox::testing {

inline geometry::Quaternion random_rotation(std::mt19937_64& random, bool yaw_only) {
  if (yaw_only) {
    std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
    return geometry::make_yaw_box({0, 0, 0}, {1, 1, 1}, angle(random)).rotation;
  }
  std::normal_distribution<double> normal;
  return geometry::Quaternion(
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
          .normalized());
}

/// `count` draws around one object: every number is moved by Gaussian noise of relative size
/// `spread` (0.1: a sure head; 1: next to no idea of size and rotation).
inline std::vector<geometry::Box> scattered_samples(std::mt19937_64& random, int count,
                                                    double spread, bool yaw_only) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d center(20 * normal(random), 20 * normal(random), normal(random));
  const Eigen::Vector3d size(4.0, 1.8, 1.5);
  const geometry::Quaternion rotation = random_rotation(random, yaw_only);
  const auto noise = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random));
  };
  std::vector<geometry::Box> samples;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d axis = noise();
    if (yaw_only) axis.head<2>().setZero();
    const double angle = spread * axis.norm();
    const geometry::Quaternion turn(
        Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())));
    samples.push_back({.center = center + 0.5 * spread * noise().cwiseProduct(size),
                       .size = size.cwiseProduct((0.5 * spread * noise()).array().exp().matrix()),
                       .rotation = (rotation * turn).normalized()});
  }
  return samples;
}

/// The largest factor by which `inner`, put at `point` of `outer`'s frame, may grow inside `outer`.
inline double room_for(const geometry::Box& outer, const geometry::Box& inner) {
  const Eigen::Matrix3d turn =
      (outer.rotation.conjugate() * inner.rotation).toRotationMatrix().cwiseAbs();
  const Eigen::Vector3d reach = turn * (0.5 * inner.size);
  const Eigen::Vector3d offset =
      (outer.rotation.conjugate() * (inner.center - outer.center)).cwiseAbs();
  return ((0.5 * outer.size - offset).array() / reach.array()).minCoeff();
}

/// Boxes of which each contains the next, from the largest to the smallest. They share faces or
/// stand free, and keep their rotation or turn.
inline std::vector<geometry::Box> nested_boxes(std::mt19937_64& random, int count, bool yaw_only) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<geometry::Box> boxes = {
      {.center = Eigen::Vector3d(100 * unit(random), 100 * unit(random), 3 * unit(random)),
       .size = Eigen::Vector3d(1 + 4 * unit(random), 1 + unit(random), 1 + unit(random)),
       .rotation = random_rotation(random, yaw_only)}};
  while (static_cast<int>(boxes.size()) < count) {
    const geometry::Box& outer = boxes.back();
    geometry::Box inner = outer;
    if (unit(random) < 0.5) {
      // Shrinks towards a corner, an edge, a face or a point inside.
      for (int a = 0; a < 3; ++a) {
        if (unit(random) < 0.3) continue;
        const double factor = 0.6 + 0.4 * unit(random);
        const double anchor = std::round(3 * unit(random)) / 3.0 - 0.5;
        inner.size[a] = factor * outer.size[a];
        inner.center +=
            inner.rotation * Eigen::Vector3d::Unit(a) * (outer.size[a] * (1 - factor) * anchor);
      }
      if (inner.size == outer.size) continue;
    } else {
      const geometry::Quaternion other = random_rotation(random, yaw_only);
      inner.rotation =
          Eigen::Quaterniond(outer.rotation).slerp(0.2 * unit(random), Eigen::Quaterniond(other));
      const double factor = std::min(1.0, room_for(outer, inner));
      inner.size *= factor * (unit(random) < 0.5 ? 1.0 : 0.9);
    }
    boxes.push_back(inner);
  }
  return boxes;
}

inline bool equal_bytes(const geometry::Box& a, const geometry::Box& b) {
  return a.center == b.center && a.size == b.size && a.rotation.coeffs() == b.rotation.coeffs();
}

/// True if every corner of `inner` is within `tolerance` of `outer`.
inline bool holds(const geometry::Box& outer, const geometry::Box& inner, double tolerance) {
  for (const Eigen::Vector3d& corner : geometry::corners(inner)) {
    if (!geometry::contains(outer, corner, tolerance)) return false;
  }
  return true;
}

}  // namespace arbox::testing
