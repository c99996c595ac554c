#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

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
  /// Of the points whose nearest facing side is square to the axis: their share of all, and their
  /// mean distance from it, metres.
  std::array<double, 2> share = {}, depth = {};

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

/// The best rectangle. Points must not be empty; one of a hundred may lie outside of each side.
Rectangle fit_l_shape(std::span<const Eigen::Vector2d> points, const LShapeSearch& search = {});

/// Every heading of the quarter turn at which the support is greater than beside it, the best
/// first, at most `count`: a view that shows little of an object leaves several.
std::vector<Rectangle> l_shapes(std::span<const Eigen::Vector2d> points, double step, int count);

}  // namespace arbox::detectors::internal
