#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "arbox/detectors/cluster_fit/cluster_fit.h"
#include "arbox/detectors/cluster_fit/internal/box_fit.h"
#include "arbox/detectors/cluster_fit/internal/ground.h"
#include "arbox/geometry/point_cloud_view.h"

/// \file
/// What ClusterFit::detect does before it chooses among objects, stage by stage. Every result is
/// the same at any thread count; threads = 0 means default_threads().

namespace arbox::detectors::internal {

using Points = std::vector<Eigen::Vector3f>;

/// The finite points within `max_range` of the origin, in order; counts the others that are not
/// finite.
Points used_points(const geometry::PointCloudView& cloud, double max_range, int threads,
                   std::int64_t& not_finite);

/// The points between the top of the ground and options.max_height, one a cube of
/// options.thinning.
Points standing_points(std::span<const Eigen::Vector3f> points, const GroundSurface& ground,
                       const ClusterFitOptions& options, int threads);

/// The points of each Euclidean cluster.
std::vector<Points> clusters_of(std::span<const Eigen::Vector3f> points, double tolerance,
                                int min_points);

/// Fits every cluster, or what it falls into when it is larger than any object. Objects of one
/// cluster stand together, those of coarser tolerances first.
std::vector<FittedObject> fit_clusters(std::vector<Points> clusters,
                                       const ClusterFitOptions& options,
                                       const Surroundings& surroundings, int threads);

}  // namespace arbox::detectors::internal
