#pragma once

#include <Eigen/Core>
#include <vector>

namespace arbox::geometry::internal {

/// Convex hull, counter-clockwise, without points on its edges. One or two points where all are
/// equal or on one line. Reorders the argument.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d>& points);

struct Rectangle {
  /// Direction of one side from +x, in (-pi / 4, pi / 4].
  double angle = 0.0;
  double area = 0.0;
};

/// The rectangle of least area around the points, sides below `least_side` counted as that long:
/// one side lies on an edge of the hull, and every edge is tried (rotating calipers).
/// O(n log n). At least one point. Reorders the argument.
Rectangle least_rectangle(std::vector<Eigen::Vector2d>& points, double least_side);

}  // namespace arbox::geometry::internal
