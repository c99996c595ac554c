#include "arbox/detectors/cluster_fit/cluster_fit.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <sstream>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/parallel.h"
#include "arbox/detectors/cluster_fit/internal/box_fit.h"
#include "arbox/detectors/cluster_fit/internal/clusters.h"
#include "arbox/detectors/cluster_fit/internal/ground.h"
#include "arbox/geometry/overlap.h"

namespace arbox::detectors {
namespace {

using internal::FittedObject;
using Points = std::vector<Eigen::Vector3f>;

constexpr std::int64_t kGrain = 16384;
// The two quantile boxes whose overlap tells the uncertainty (paper, section 4.3).
constexpr double kUncertaintyLow = 0.2;
constexpr double kUncertaintyHigh = 0.8;

Points used_points(const geometry::PointCloudView& cloud, double max_range,
                   std::int64_t& not_finite) {
  Points points;
  points.reserve(cloud.size());
  const auto limit = static_cast<float>(max_range);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point = cloud.position(i);
    if (!point.allFinite()) {
      ++not_finite;
    } else if (std::abs(point.x()) <= limit && std::abs(point.y()) <= limit &&
               std::abs(point.z()) <= limit && point.norm() <= limit) {
      points.push_back(point);
    }
  }
  return points;
}

Points standing_points(const Points& points, const internal::GroundSurface& ground,
                       const ClusterFitOptions& options, int threads) {
  const auto count = static_cast<std::int64_t>(points.size());
  std::vector<Points> parts((count + kGrain - 1) / kGrain);
  parallel_for(count, kGrain, threads, [&](std::int64_t begin, std::int64_t end) {
    Points& part = parts[begin / kGrain];
    for (std::int64_t i = begin; i < end; ++i) {
      const double above = points[i].z() - ground.height(points[i].x(), points[i].y());
      if (above > options.ground.thickness && above < options.max_height) part.push_back(points[i]);
    }
  });
  Points standing;
  for (const Points& part : parts) standing.insert(standing.end(), part.begin(), part.end());
  return standing;
}

Points selected(const Points& points, const std::vector<std::uint32_t>& indices) {
  Points result;
  result.reserve(indices.size());
  for (const auto i : indices) result.push_back(points[i]);
  return result;
}

/// Fits the cluster, or what it falls into when it is larger than any object.
std::vector<FittedObject> fit_cluster(Points cluster, const ClusterFitOptions& options,
                                      const internal::Surroundings& surroundings) {
  const double step = options.yaw_step * std::numbers::pi / 180.0;
  std::vector<FittedObject> objects;
  std::deque<std::pair<Points, double>> waiting;
  waiting.emplace_back(std::move(cluster), options.tolerance);
  while (!waiting.empty()) {
    const auto [points, tolerance] = std::move(waiting.front());
    waiting.pop_front();
    if (!internal::larger_than_any_object(points)) {
      std::vector<Eigen::Vector2d> outline = internal::outline_of(points);
      const internal::Rectangle rectangle = internal::fit_l_shape(outline, {.step = step});
      if (!internal::larger_than_any_object(rectangle)) {
        objects.push_back(
            internal::fit_object(points, std::move(outline), rectangle, surroundings));
        continue;
      }
    }
    const double finer = 0.5 * tolerance;
    if (finer < options.min_tolerance) continue;
    for (const auto& part : internal::euclidean_clusters(points, finer, options.min_points)) {
      waiting.emplace_back(selected(points, part), finer);
    }
  }
  return objects;
}

std::vector<FittedObject> best_apart(std::vector<FittedObject> objects, double nms_iou) {
  std::stable_sort(objects.begin(), objects.end(),
                   [](const auto& one, const auto& other) { return one.score > other.score; });
  std::vector<FittedObject> kept;
  for (FittedObject& object : objects) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const FittedObject& better) {
      const double reach = 0.5 * (better.box.size.norm() + object.box.size.norm());
      return (better.box.center - object.box.center).norm() < reach &&
             geometry::overlap(better.box, object.box,
                               {.space = geometry::OverlapSpace::kBirdsEye}) > nms_iou;
    });
    if (!covered) kept.push_back(std::move(object));
  }
  return kept;
}

/// Draws box samples and derives from them all that the request asks for.
void add_uncertainty(const std::vector<FittedObject>& objects, int count,
                     const DetectionRequest& request, const internal::Surroundings& surroundings,
                     std::vector<geometry::Detection>& detections) {
  parallel_for(static_cast<std::int64_t>(objects.size()), 1, request.threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   detections[i].samples =
                       internal::sample_boxes(objects[i], count, request.seed, surroundings);
                 }
               });
  // One pass answers all: the quantiles asked for, q = 1 - p for each confidence, and the two of U.
  std::vector<double> qs = request.quantiles;
  for (const double p : request.confidences) qs.push_back(1.0 - p);
  qs.insert(qs.end(), {kUncertaintyLow, kUncertaintyHigh});
  std::vector<geometry::BoxSamples> samples;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    samples.push_back({.boxes = detections[i].samples, .object = objects[i].id});
  }
  const auto boxes =
      geometry::quantile_boxes(samples, qs, {.seed = request.seed, .threads = request.threads});
  for (std::size_t i = 0; i < objects.size(); ++i) {
    geometry::Detection& detection = detections[i];
    auto next = boxes[i].begin();
    for (std::size_t k = 0; k < request.quantiles.size(); ++k) {
      detection.quantile_boxes.push_back(*next++);
    }
    for (const double p : request.confidences) {
      detection.confidence_boxes.push_back({.p = p, .box = (next++)->box});
    }
    detection.uncertainty = 1.0 - geometry::overlap(next[0].box, next[1].box);
    if (!request.samples) detection.samples.clear();
  }
}

void require_within(double value, double low, double high, const char* what) {
  if (value > low && value < high) return;
  std::ostringstream text;
  text << "ClusterFit: " << what << " must be between " << low << " and " << high << ", got "
       << value;
  throw InvalidArgument(text.str());
}

}  // namespace

ClusterFit::ClusterFit(const ClusterFitOptions& options) : options_(options) {
  validate_options(options_, "ClusterFit");
}

DetectionResult ClusterFit::detect(const geometry::PointCloudView& cloud,
                                   const DetectionRequest& request) const {
  if (!(request.score >= 0.0 && request.score <= 1.0)) {
    throw InvalidArgument("ClusterFit: the score must be from 0 to 1, got " +
                          std::to_string(request.score));
  }
  for (const double q : request.quantiles) require_within(q, 0.0, 1.0, "a quantile");
  for (const double p : request.confidences) require_within(p, 0.0, 1.0, "a confidence");
  DetectionResult result;
  const Points points = used_points(cloud, options_.max_range, result.dropped_points);
  const internal::GroundSurface ground(points, options_.ground, options_.max_range,
                                       request.threads);
  Points standing = standing_points(points, ground, options_, request.threads);
  if (options_.thinning > 0.0) {
    standing = selected(standing, internal::thinned(standing, options_.thinning));
  }
  const internal::OcclusionMap occlusion(standing);
  const internal::Surroundings surroundings{.ground = [&](double x, double y) -> double {
                                              return ground.height(static_cast<float>(x),
                                                                   static_cast<float>(y));
                                            },
                                            .occlusion = &occlusion};

  const auto clusters =
      internal::euclidean_clusters(standing, options_.tolerance, options_.min_points);
  std::vector<std::vector<FittedObject>> fitted(clusters.size());
  parallel_for(static_cast<std::int64_t>(clusters.size()), 1, request.threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   fitted[i] = fit_cluster(selected(standing, clusters[i]), options_, surroundings);
                 }
               });
  std::vector<FittedObject> candidates;
  for (std::size_t cluster = 0; cluster < fitted.size(); ++cluster) {
    for (std::size_t part = 0; part < fitted[cluster].size(); ++part) {
      FittedObject& object = fitted[cluster][part];
      object.id = (static_cast<std::uint64_t>(cluster) << 32) + part;
      if (object.score >= request.score) candidates.push_back(std::move(object));
    }
  }
  const std::vector<FittedObject> objects = best_apart(std::move(candidates), options_.nms_iou);
  for (const FittedObject& object : objects) {
    geometry::Detection& detection = result.detections.emplace_back();
    detection.label = object.prior->label;
    detection.score = object.score;
    detection.box = object.box;
  }
  if (request.samples || !request.quantiles.empty() || !request.confidences.empty()) {
    add_uncertainty(objects, options_.sample_count, request, surroundings, result.detections);
  }
  return result;
}

void register_cluster_fit(Registrar& registrar) {
  registrar.add<DetectorKind, ClusterFitOptions>(
      "cluster_fit", "Ground, clusters, L-shapes and size priors: the classical baseline",
      [](const ClusterFitOptions& options) { return std::make_unique<ClusterFit>(options); });
}

}  // namespace arbox::detectors
