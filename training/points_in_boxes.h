#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "arbox/training/scene.h"

/// \file
/// Which points of a cloud boxes hold, faces included. Non-finite points are in no box. Cost:
/// linear in the points, however many boxes there are, unless many overlap.

namespace arbox::training {

/// For every box the indices of its points, ascending.
std::vector<std::vector<std::size_t>> points_inside(const geometry::PointCloud& cloud,
                                                    std::span<const geometry::Box> boxes);

/// For every object the number of its points.
std::vector<std::int64_t> count_points(const geometry::PointCloud& cloud,
                                       std::span<const SceneObject> objects);

/// Leaves out the points that one of the boxes holds.
void remove_points_inside(geometry::PointCloud& cloud, std::span<const geometry::Box> boxes);

}  // namespace arbox::training
