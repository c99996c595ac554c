#pragma once

#include "arbox/geometry/internal/point_set.h"

/// \file
/// Smallest boxes around a padded, non-empty PointSet; boxes are relative to its origin. Sizes
/// below `least_size` count as that long, so that flat sets have a smallest box too; the boxes
/// returned keep their true extents.

namespace arbox::geometry::internal {

/// Volume with each size at least `least_size`.
double clamped_volume(const Eigen::Vector3d& size, double least_size);

/// The box around the points with that rotation.
Box box_about(const PointSet& points, const Quaternion& rotation);

/// The smallest box whose own z axis is that of `rotation`, over all turns about it; its rotation
/// is `rotation` turned by at most an eighth of a turn.
Box smallest_about(const PointSet& points, const Quaternion& rotation, double least_size = 0.0);

/// Tilts that a search tries, from the first to the last by halves, radians.
struct TiltSteps {
  double first = 0.2;
  double last = 1e-7;
};

/// Local search over all rotations from `start`, a box around the points: never larger than it.
/// The axes keep their names as far as the nearest equivalent rotation allows.
Box descend(const PointSet& points, const Box& start, const TiltSteps& steps = {},
            double least_size = 0.0);

}  // namespace arbox::geometry::internal
