#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "arbox/geometry/box.h"

namespace arbox::geometry::internal {

/// Points as three arrays, relative to an origin of the owner's choice, padded with copies of the
/// first point for the kernels.
struct PointSet {
  std::vector<double> x, y, z;
  /// Points before the padding; set by pad().
  std::size_t count = 0;

  void reserve(std::size_t expected);
  void push_back(double px, double py, double pz) {
    x.push_back(px);
    y.push_back(py);
    z.push_back(pz);
  }
  Eigen::Vector3d operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  /// Call once after the last push_back.
  void pad();
};

/// Lows along the three own axes of a rotation, then highs.
using Extents = std::array<double, 6>;
/// The own axes of a rotation as rows: rows * p is p in the rotated frame.
using RotationRows = std::array<double, 9>;

Extents empty_extents();
RotationRows rows_of(const Quaternion& rotation);

/// Widens extents[r] to all the points as seen in the frame of rotations[r].
void widen(const PointSet& points, std::span<const RotationRows> rotations,
           std::span<Extents> extents);

Eigen::Vector3d size_of(const Extents& extents);
Box box_of(const Extents& extents, const Quaternion& rotation, const Eigen::Vector3d& origin);

/// Index of the extents with the least volume, the first of equals.
std::size_t least_volume(std::span<const Extents> extents);

}  // namespace arbox::geometry::internal
