#include "arbox/plugins/cgal/minimum_volume_box.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/optimal_bounding_box.h>

#include <array>
#include <vector>

namespace arbox::cgal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// Thinner than this share of its length, a set counts as flat.
constexpr double kFlat = 1e-9;

geometry::Quaternion rotation_of(const std::array<Kernel::Point_3, 8>& corners) {
  const auto direction = [&](std::size_t to) {
    const auto edge = corners[to] - corners[0];
    return Eigen::Vector3d(edge.x(), edge.y(), edge.z());
  };
  // The longest edges fix the axes best.
  std::array<Eigen::Vector3d, 3> edges = {direction(1), direction(3), direction(5)};
  std::sort(edges.begin(), edges.end(),
            [](const auto& a, const auto& b) { return a.norm() > b.norm(); });
  Eigen::Matrix3d axes;
  axes.col(0) = edges[0].normalized();
  axes.col(1) = (edges[1] - axes.col(0).dot(edges[1]) * axes.col(0)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return geometry::Quaternion(axes);
}

}  // namespace

std::optional<geometry::Box> minimum_volume_box(std::span<const Eigen::Vector3d> points,
                                                double minimum_size) {
  const auto own = geometry::minimum_volume_box(points, minimum_size);
  if (!own || own->size.minCoeff() <= std::max(minimum_size, kFlat * own->size.maxCoeff())) {
    return own;
  }
  std::vector<Kernel::Point_3> converted;
  for (const Eigen::Vector3d& p : points) converted.emplace_back(p.x(), p.y(), p.z());
  std::array<Kernel::Point_3, 8> corners;
  CGAL::oriented_bounding_box(converted, corners, CGAL::parameters::use_convex_hull(true));
  const geometry::Quaternion rotation = rotation_of(corners);
  return geometry::enclosing_box(points, std::span(&rotation, 1), minimum_size);
}

}  // namespace arbox::cgal
