#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

namespace arbox::detectors::internal {

/// The rectangle around points in the xy plane whose sides that face the origin lie closest to
/// them.
struct Rectangle {
  /// Direction of axis 0, in [0, pi / 2) unless the search was local; axis 1 is a quarter turn
  /// ahead.
  double yaw = 0.0;
  /// Extents along the two axes, measured from the origin (the sensor), metres.
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  /// Mean closeness of the points to a facing side, in (0, 1]: 1 when all lie on one.
  double support = 0.0;

  /// +1 if the origin lies beyond the high end of the axis, -1 if beyond the low end, 0 if between.
  int sensor_side(int axis) const {
    if (high[axis] < 0.0) return 1;
    return low[axis] > 0.0 ? -1 : 0;
  }
  /// A corner in the xy plane; ends are 0 (low) and 1 (high).
  Eigen::Vector2d corner(int end0, int end1) const;
};

struct LShapeSearch {
  /// First step between headings, radians.
  double step = 0.035;
  /// Search only within `window` of this heading instead of the whole quarter turn.
  std::optional<double> around = {};
  double window = 0.12;
};

/// Points must not be empty; one of a hundred may lie outside of each side.
Rectangle fit_l_shape(std::span<const Eigen::Vector2d> points, const LShapeSearch& search = {});

}  // namespace arbox::detectors::internal
