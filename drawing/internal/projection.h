#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "arbox/drawing/internal/canvas.h"

namespace arbox::drawing {

/// A camera, orthographic or perspective: pixel = (a, b) / w with (a, b, w) = matrix * (p, 1).
/// What has w below `near` is cut off.
struct Projection {
  Eigen::Matrix<double, 3, 4> matrix = Eigen::Matrix<double, 3, 4>::Zero();
  double near = 0.1;

  Eigen::Vector3d homogeneous(const Eigen::Vector3d& point) const {
    return matrix.leftCols<3>() * point + matrix.col(3);
  }
  /// The pixel of a point that is not cut off.
  std::optional<Point> operator()(const Eigen::Vector3d& point) const;
  /// What is left of a segment.
  std::optional<std::pair<Point, Point>> segment(const Eigen::Vector3d& from,
                                                 const Eigen::Vector3d& to) const;
  /// What is left of a convex polygon; empty if nothing is.
  std::vector<Point> polygon(const std::vector<Eigen::Vector3d>& corners) const;
};

/// Seen from above, x (forward) up and y (left) to the left; `center` in the middle of `rect`.
Projection birdseye_projection(const Eigen::Vector3d& center, double pixels_per_metre,
                               const Rect& rect);

/// Seen from direction (azimuth, elevation), degrees, from so far that all of the given points (at
/// least one) are within `rect` and fill it. Objects are in front of the camera.
Projection perspective_projection(std::span<const Eigen::Vector3d> shown, double azimuth,
                                  double elevation, const Rect& rect);

}  // namespace arbox::drawing
