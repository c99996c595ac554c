#pragma once

#include <span>
#include <vector>

#include "arbox/geometry/box.h"

/// \file
/// Overlap as it is usually written: every pair is clipped, one after the other, on one thread.
/// The baseline of overlap_benchmark, and the boxes that both run on.

namespace arbox::benchmarks {

/// Row-major IoU matrix of yaw-only boxes: one base is clipped by the edges of the other.
std::vector<double> naive_yaw_iou(std::span<const geometry::Box> first,
                                  std::span<const geometry::Box> second);

/// Row-major IoU matrix of boxes of any rotation: one box's faces are clipped by the half-spaces of
/// the other and the cuts are closed.
std::vector<double> naive_free_iou(std::span<const geometry::Box> first,
                                   std::span<const geometry::Box> second);

/// Cars at random places and headings on 70 x 70 m.
std::vector<geometry::Box> spread_cars(int count, std::uint64_t seed);

/// Proposals that scatter around 15 cars: centres by 0.3 m, sizes by 5 %, headings by 0.1 rad. The
/// cars are the same for every seed.
std::vector<geometry::Box> clustered_proposals(int count, std::uint64_t seed);

/// Boxes of any rotation, centres in a cube of `room` metres, sides of 0.2 to 1.2 m.
std::vector<geometry::Box> dense_boxes(int count, std::uint64_t seed, double room = 1.0);

}  // namespace arbox::benchmarks
