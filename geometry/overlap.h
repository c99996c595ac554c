#pragma once

#include <Eigen/Core>
#include <span>

#include "arbox/geometry/box.h"

/// \file
/// Exact overlap of boxes: intersection volume, IoU and IoG of boxes of any rotation.
///
/// Computed in double from the difference of the centres, without tolerances, so that touching,
/// nested, coincident and nearly coplanar faces, and coordinates of 1e6 m, are ordinary input. The
/// intersection's error is below 1e-9 of the smaller box's volume while no box is more than 1e6
/// times as long as the thinnest is thick or 1e6 times as long as the other, and near 1e-15 for
/// boxes of ordinary shape. Boxes that do not overlap give 0, IoU and IoG lie in [0, 1], and
/// nothing is NaN.
///
/// Refused with InvalidArgument that names the row: what require_valid() refuses (sizes that are
/// zero, negative or not finite, quaternions that are not of unit norm within 1e-6), and sizes
/// outside of [1e-40, 1e40] m, whose volumes a double cannot hold.
///
/// A pair's result depends on the pair, the options and the CPU's instruction set alone: not on
/// threads, nor on what else is in the batch. All functions may be called from any thread.

namespace arbox::geometry {

/// What is computed of a pair: intersection volume (m^3), intersection over union, or intersection
/// over the volume of the second box (the ground truth; paper, section 5.2).
enum class Overlap { kIntersection, kIou, kIog };

enum class OverlapSpace {
  /// Volumes in full 3-D.
  k3d,
  /// Areas (m^2) of the boxes' bases seen from above; z and height count for nothing. Only boxes
  /// whose z axis is the frame's: others have no one base, and are refused with InvalidArgument
  /// unless their tilt is that of float32 rounding (sine up to 1e-6), which is ignored.
  kBirdsEye,
  /// Volumes of the boxes with their rotations ignored.
  kAxisAligned
};

struct OverlapOptions {
  Overlap measure = Overlap::kIou;
  OverlapSpace space = OverlapSpace::k3d;
  /// 0 means default_threads().
  int threads = 0;
};

/// Overlap of one pair. 0.1 to 1 microsecond; for many pairs the functions below are faster.
double overlap(const Box& first, const Box& second, const OverlapOptions& options = {});

/// (first.size(), second.size()) matrix, row-major; without rows or columns if a span is empty.
/// Pairs whose enclosing cylinders are apart cost about a nanosecond.
Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> overlap_matrix(
    std::span<const Box> first, std::span<const Box> second, const OverlapOptions& options = {});

/// Overlap of first[i] with second[i]; both spans have the same length, else InvalidArgument.
Eigen::VectorXd overlap_pairs(std::span<const Box> first, std::span<const Box> second,
                              const OverlapOptions& options = {});

}  // namespace arbox::geometry
