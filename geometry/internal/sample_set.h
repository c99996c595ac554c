#pragma once

#include <string_view>
#include <vector>

#include "arbox/geometry/internal/point_kernels.h"
#include "arbox/geometry/internal/point_set.h"
#include "arbox/geometry/quantile_box.h"

namespace arbox::geometry::internal {

/// The samples of one object without repetition, relative to the first one's centre.
struct SampleSet {
  Eigen::Vector3d origin;
  /// The samples of non-zero weight that differ, each with the summed weight of its copies.
  std::vector<Box> boxes;
  std::vector<double> weights;
  /// Their rotations without repetition.
  std::vector<Quaternion> rotations;
  double total_weight = 0.0;
  bool yaw_only = true;
};

/// Throws InvalidArgument that names `where` for no samples, bad boxes or weights.
void require_valid(const BoxSamples& samples, std::string_view where);
/// Throws InvalidArgument for options out of their ranges.
void require_valid(const QuantileOptions& options);

SampleSet make_sample_set(const BoxSamples& samples);

/// See occupancy_points(); relative to the set's origin.
PointSet make_points(const BoxSamples& samples, const SampleSet& set,
                     const QuantileOptions& options);

/// The occupancy of each point.
std::vector<double> occupancies(const SampleSet& set, const PointSet& points);

}  // namespace arbox::geometry::internal
