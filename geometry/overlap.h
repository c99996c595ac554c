#pragma once

#include <Eigen/Core>
#include <span>

#include "arbox/geometry/box.h"

/// \file
/// Exact overlap of boxes. All functions refuse invalid boxes (require_valid) with
/// InvalidArgument that names the row, and never return NaN.

namespace arbox::geometry {

/// What is computed of a pair: intersection volume (m^3), intersection over union, or intersection
/// over the volume of the second box (the ground truth; paper, section 5.2).
enum class Overlap { kIntersection, kIou, kIog };

/// The space in which boxes meet: full 3-D; bird's eye (the projections on the xy plane of yaw-only
/// boxes, areas in m^2); axis-aligned (rotations ignored).
enum class OverlapSpace { k3d, kBirdsEye, kAxisAligned };

struct OverlapOptions {
  Overlap measure = Overlap::kIou;
  OverlapSpace space = OverlapSpace::k3d;
  /// 0 means default_threads().
  int threads = 0;
};

/// Overlap of one pair.
double overlap(const Box& first, const Box& second, const OverlapOptions& options = {});

/// (first.size(), second.size()) matrix, row-major.
Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> overlap_matrix(
    std::span<const Box> first, std::span<const Box> second, const OverlapOptions& options = {});

/// Overlap of first[i] with second[i]; both spans have the same length, else InvalidArgument.
Eigen::VectorXd overlap_pairs(std::span<const Box> first, std::span<const Box> second,
                              const OverlapOptions& options = {});

}  // namespace arbox::geometry
