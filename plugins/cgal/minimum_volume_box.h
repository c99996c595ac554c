#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "arbox/geometry/enclosing_box.h"

namespace arbox::cgal {

/// geometry::minimum_volume_box with CGAL's search for the rotation (Chang, Gorissen, Melchior,
/// "Fast oriented bounding box optimization on the rotation group", 2011) in place of ours, on the
/// convex hull of the points: the same arguments, answers and errors. Not proved to be the smallest
/// box either; tests/cgal compares both. Flat sets, of which CGAL makes nothing, are answered by
/// ours.
///
/// CGAL's package Optimal_bounding_box is under the GPL: so is every program that links this.
std::optional<geometry::Box> minimum_volume_box(std::span<const Eigen::Vector3d> points,
                                                double minimum_size = geometry::kMinimumBoxSize);

}  // namespace arbox::cgal
