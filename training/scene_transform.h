#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/training/scene.h"

/// \file
/// Changes to a whole scene: points, boxes and ground move together, so that a point that was
/// inside a box stays inside (up to float32 rounding of the points). Intensities and the order of
/// points stay. Boxes stand upright.

namespace arbox::training {

/// Mirrors left and right: y becomes -y, headings change their sign.
void flip_left_right(Scene& scene);

/// Mirrors front and back: x becomes -x, a heading becomes pi minus itself.
void flip_front_back(Scene& scene);

/// Turns everything about +z by `angle` radians, counter-clockwise.
void rotate(Scene& scene, double angle);

/// Multiplies places and sizes. Throws InvalidArgument unless the factor is finite and above zero.
void scale(Scene& scene, double factor);

/// Height (z) of the ground under or over (x, y). Throws InvalidArgument for a plane that stands
/// upright.
double ground_height(const io::KittiPlane& ground, double x, double y);

/// Indices of the points that the box holds, faces included, ascending. Linear, some nanoseconds a
/// point. Non-finite points are in no box.
std::vector<std::size_t> points_inside(const geometry::PointCloud& cloud, const geometry::Box& box);

/// For every box the number of points that it holds.
std::vector<std::int64_t> count_points(const geometry::PointCloud& cloud,
                                       std::span<const SceneObject> objects, int threads = 1);

/// Leaves out the points that one of the boxes holds.
void remove_points_inside(geometry::PointCloud& cloud, std::span<const geometry::Box> boxes);

}  // namespace arbox::training
