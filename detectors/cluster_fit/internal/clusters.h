#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace arbox::detectors::internal {

/// Indices of the first point of each occupied cube of edge `edge` > 0, ascending.
std::vector<std::uint32_t> thinned(std::span<const Eigen::Vector3f> points, double edge);

/// Groups of points connected by steps of at most `tolerance` metres: the clusters of
/// pcl::EuclideanClusterExtraction, found in linear time on a grid whose cells are so small that
/// all points of a cell belong together. Members ascend; clusters ascend by first member; those
/// with fewer than `min_points` are left out. |coordinates| / tolerance must stay below 5e5.
std::vector<std::vector<std::uint32_t>> euclidean_clusters(std::span<const Eigen::Vector3f> points,
                                                           double tolerance, int min_points);

}  // namespace arbox::detectors::internal
