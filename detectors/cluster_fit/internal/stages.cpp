#include "arbox/detectors/cluster_fit/internal/stages.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <iterator>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "arbox/base/parallel.h"
#include "arbox/detectors/cluster_fit/internal/clusters.h"
#include "arbox/detectors/cluster_fit/internal/outline.h"

namespace arbox::detectors::internal {
namespace {

constexpr std::int64_t kGrain = 4096;
// Rectangles that are compared for a cluster.
constexpr int kRectangles = 3;

/// Joins in order what body(begin, end, part) appends for the ranges of [0, count).
template <class Body>
Points gather(std::size_t count, int threads, Body&& body) {
  std::vector<Points> parts((count + kGrain - 1) / kGrain);
  parallel_for(static_cast<std::int64_t>(count), kGrain, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 Points& part = parts[begin / kGrain];
                 part.reserve(end - begin);
                 body(begin, end, part);
               });
  Points all;
  all.reserve(std::transform_reduce(parts.begin(), parts.end(), std::size_t{0}, std::plus<>(),
                                    [](const Points& part) { return part.size(); }));
  for (const Points& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

Points selected(std::span<const Eigen::Vector3f> points,
                const std::vector<std::uint32_t>& indices) {
  Points result;
  result.reserve(indices.size());
  for (const auto i : indices) result.push_back(points[i]);
  return result;
}

/// A cluster or what it fell into, and what came of it.
struct Part {
  Points points;
  std::size_t cluster = 0;
  std::optional<FittedObject> object = {};
  std::vector<Points> finer = {};
};

void fit_part(Part& part, double finer_tolerance, const ClusterFitOptions& options,
              const Surroundings& surroundings) {
  if (!larger_than_any_object(part.points)) {
    std::vector<Eigen::Vector2d> outline = outline_of(part.points);
    const double step = options.yaw_step * std::numbers::pi / 180.0;
    std::vector<Rectangle> rectangles = l_shapes(outline, step, kRectangles);
    if (!larger_than_any_object(rectangles[0])) {
      std::erase_if(rectangles, [](const auto& other) { return larger_than_any_object(other); });
      part.object = fit_object(part.points, std::move(outline), rectangles, surroundings);
      return;
    }
  }
  if (finer_tolerance < options.min_tolerance) return;
  part.finer = clusters_of(part.points, finer_tolerance, options.min_points);
}

/// Places of the parts, the largest first, so that no thread begins with one at the end.
std::vector<std::size_t> largest_first(const std::vector<Part>& parts) {
  std::vector<std::size_t> order(parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto one, auto other) {
    return parts[one].points.size() > parts[other].points.size();
  });
  return order;
}

}  // namespace

Points used_points(const geometry::PointCloudView& cloud, double max_range, int threads,
                   std::int64_t& not_finite) {
  const auto limit = static_cast<float>(max_range * max_range);
  std::atomic<std::int64_t> dropped{0};
  Points points = gather(cloud.size(), threads, [&](auto begin, auto end, Points& part) {
    for (auto i = begin; i < end; ++i) {
      const Eigen::Vector3f point = cloud.position(i);
      if (point.squaredNorm() <= limit) {
        part.push_back(point);
      } else if (!point.allFinite()) {
        ++dropped;
      }
    }
  });
  not_finite += dropped;
  return points;
}

Points standing_points(std::span<const Eigen::Vector3f> points, const GroundSurface& ground,
                       const ClusterFitOptions& options, int threads) {
  Points standing = gather(points.size(), threads, [&](auto begin, auto end, Points& part) {
    const auto range = points.subspan(begin, end - begin);
    const std::vector<float> floor = ground.heights(range);
    for (std::size_t i = 0; i < range.size(); ++i) {
      const float above = range[i].z() - floor[i];
      if (above > options.ground.thickness && above < options.max_height) part.push_back(range[i]);
    }
  });
  if (options.thinning <= 0.0) return standing;
  return selected(standing, thinned(standing, options.thinning));
}

std::vector<Points> clusters_of(std::span<const Eigen::Vector3f> points, double tolerance,
                                int min_points) {
  std::vector<Points> clusters;
  for (const auto& members : euclidean_clusters(points, tolerance, min_points)) {
    clusters.push_back(selected(points, members));
  }
  return clusters;
}

std::vector<FittedObject> fit_clusters(std::vector<Points> clusters,
                                       const ClusterFitOptions& options,
                                       const Surroundings& surroundings, int threads) {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < clusters.size(); ++i) parts.push_back({std::move(clusters[i]), i});
  std::vector<std::vector<FittedObject>> fitted(clusters.size());
  for (double finer = 0.5 * options.tolerance; !parts.empty(); finer *= 0.5) {
    const std::vector<std::size_t> order = largest_first(parts);
    parallel_for(static_cast<std::int64_t>(parts.size()), 1, threads,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (auto i = begin; i < end; ++i) {
                     fit_part(parts[order[i]], finer, options, surroundings);
                   }
                 });
    std::vector<Part> next;
    for (Part& part : parts) {
      auto& objects = fitted[part.cluster];
      if (part.object) {
        part.object->id = (static_cast<std::uint64_t>(part.cluster) << 32) + objects.size();
        objects.push_back(std::move(*part.object));
      }
      for (Points& points : part.finer) next.push_back({std::move(points), part.cluster});
    }
    parts = std::move(next);
  }
  std::vector<FittedObject> objects;
  for (auto& some : fitted) std::move(some.begin(), some.end(), std::back_inserter(objects));
  return objects;
}

}  // namespace arbox::detectors::internal
