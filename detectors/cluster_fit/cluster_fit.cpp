#include "arbox/detectors/cluster_fit/cluster_fit.h"

#include <algorithm>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/parallel.h"
#include "arbox/detectors/cluster_fit/internal/box_fit.h"
#include "arbox/detectors/cluster_fit/internal/stages.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/overlap.h"

namespace arbox::detectors {
namespace {

using internal::FittedObject;

// The two quantile boxes whose overlap tells the uncertainty (paper, section 4.3).
constexpr double kUncertaintyLow = 0.2;
constexpr double kUncertaintyHigh = 0.8;

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
  // One pass answers both: the quantiles asked for, and the two of U.
  std::vector<double> qs = request.quantiles;
  qs.insert(qs.end(), {kUncertaintyLow, kUncertaintyHigh});
  std::vector<geometry::BoxSamples> samples;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    samples.push_back({.boxes = detections[i].samples, .object = objects[i].id});
  }
  const geometry::QuantileOptions options{.seed = request.seed, .threads = request.threads};
  const auto boxes = geometry::quantile_boxes(samples, qs, options);
  const auto confidence = geometry::confidence_boxes(samples, request.confidences, options);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    geometry::Detection& detection = detections[i];
    auto next = boxes[i].begin();
    for (std::size_t k = 0; k < request.quantiles.size(); ++k) {
      detection.quantile_boxes.push_back(*next++);
    }
    detection.confidence_boxes = confidence[i];
    detection.uncertainty = geometry::quantile_uncertainty(next[0].box, next[1].box);
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
  if (!request.known_sizes.empty()) {
    throw InvalidArgument(
        "ClusterFit: expected no known sizes, since it does not know how likely a size is; models "
        "whose head is autoregressive, gaussian or discrete do");
  }
  for (const double q : request.quantiles) require_within(q, 0.0, 1.0, "a quantile");
  for (const double p : request.confidences) require_within(p, 0.0, 1.0, "a confidence");
  DetectionResult result;
  const internal::Points points =
      internal::used_points(cloud, options_.max_range, request.threads, result.dropped_points);
  const internal::GroundSurface ground(points, options_.ground, options_.max_range,
                                       request.threads);
  const internal::Points standing =
      internal::standing_points(points, ground, options_, request.threads);
  const internal::OcclusionMap occlusion(standing);
  const internal::Surroundings surroundings{.ground = [&](double x, double y) -> double {
                                              return ground.height(static_cast<float>(x),
                                                                   static_cast<float>(y));
                                            },
                                            .occlusion = &occlusion};

  std::vector<FittedObject> candidates = internal::fit_clusters(
      internal::clusters_of(standing, options_.tolerance, options_.min_points), options_,
      surroundings, request.threads);
  std::erase_if(candidates, [&](const auto& object) { return object.score < request.score; });
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
