#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "arbox/detectors/cluster_fit/internal/l_shape.h"

namespace arbox::detectors::internal {

/// Sorts out clusters that cannot be an object by their size alone. Points must not be empty.
bool larger_than_any_object(const Rectangle& rectangle);
bool larger_than_any_object(std::span<const Eigen::Vector3f> points);

/// Means of the points in squares of 0.1 m.
std::vector<Eigen::Vector2d> outline_of(std::span<const Eigen::Vector3f> points);

}  // namespace arbox::detectors::internal
