#pragma once

#include <rapidcheck.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "arbox/geometry/box.h"

/// \file
/// RapidCheck generators of boxes. They draw whole boxes from one integer, because a box that
/// fails has no use for shrinking.

namespace arbox::testing {

/// Uniform doubles in [low, high).
inline rc::Gen<double> number_between(double low, double high) {
  return rc::gen::noShrink(
      rc::gen::map(rc::gen::inRange<std::int64_t>(0, std::int64_t{1} << 50), [=](std::int64_t i) {
        return low + (high - low) * std::ldexp(static_cast<double>(i), -50);
      }));
}

inline rc::Gen<Eigen::Vector3d> vector_between(double low, double high) {
  const auto coordinate = number_between(low, high);
  return rc::gen::map(rc::gen::tuple(coordinate, coordinate, coordinate), [](const auto& t) {
    return Eigen::Vector3d(std::get<0>(t), std::get<1>(t), std::get<2>(t));
  });
}

/// Uniform over all rotations (Shoemake's method).
inline rc::Gen<geometry::Quaternion> any_rotation() {
  return rc::gen::map(vector_between(0.0, 1.0), [](const Eigen::Vector3d& u) {
    const double a = 2.0 * std::numbers::pi * u.y();
    const double b = 2.0 * std::numbers::pi * u.z();
    const double s = std::sqrt(1.0 - u.x());
    const double c = std::sqrt(u.x());
    return geometry::Quaternion(s * std::sin(a), s * std::cos(a), c * std::sin(b), c * std::cos(b));
  });
}

inline rc::Gen<geometry::Box> any_box() {
  return rc::gen::map(
      rc::gen::tuple(vector_between(-10, 10), vector_between(0.1, 5.0), any_rotation()),
      [](const auto& t) {
        return geometry::Box{
            .center = std::get<0>(t), .size = std::get<1>(t), .rotation = std::get<2>(t)};
      });
}

}  // namespace arbox::testing
