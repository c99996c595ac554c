#include "arbox/detectors/pv_rcnn/internal/post_processing.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/isfinite.h>

#include <algorithm>
#include <cmath>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/box_rows.h"
#include "arbox/detectors/pv_rcnn/internal/head_answer.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/nms.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

using at::Tensor;

/// Regions that are still in the running, as rows of the proposals, with what is known of them.
struct Candidates {
  std::vector<std::int64_t> rows;
  std::vector<double> scores;
  std::vector<int> labels;
  std::vector<geometry::Box> boxes;

  void add(std::int64_t row, double score, int label, const geometry::Box& box) {
    rows.push_back(row);
    scores.push_back(score);
    labels.push_back(label);
    boxes.push_back(box);
  }
  Candidates select(const std::vector<std::int64_t>& index) const {
    Candidates result;
    for (const std::int64_t i : index) result.add(rows[i], scores[i], labels[i], boxes[i]);
    return result;
  }
};

/// Distance between the sensor, at the origin, and a yaw-only box, seen from above.
double distance_from_sensor(const geometry::Box& box) {
  const Eigen::Vector3d sensor = box.rotation.conjugate() * -box.center;
  const Eigen::Vector2d outside = sensor.head<2>().cwiseAbs() - box.size.head<2>() / 2;
  return outside.cwiseMax(0).norm();
}

/// Regions with finite numbers, a score of at least `score` and enough clearance, with their
/// pointwise boxes.
Candidates scored(const RegionResults& results, double score, double clearance,
                  std::int64_t& dropped) {
  const Proposals& proposals = results.proposals;
  const Tensor finite = at::isfinite(results.second.features)
                            .all(1)
                            .logical_and(at::isfinite(results.second.confidence))
                            .logical_and(at::isfinite(results.second.residuals).all(1))
                            .contiguous();
  const Tensor sigmoid = results.second.confidence.sigmoid().to(at::kDouble).contiguous();
  const Tensor labels = proposals.labels.contiguous();
  const UsableBoxes boxes =
      usable_boxes(decode_region_residuals(results.second.residuals, proposals.boxes));
  Candidates candidates;
  dropped += boxes.dropped;
  for (std::size_t i = 0; i < boxes.rows.size(); ++i) {
    const std::int64_t row = boxes.rows[i];
    if (!finite.data_ptr<bool>()[row]) {
      ++dropped;
    } else if (sigmoid.data_ptr<double>()[row] >= score &&
               distance_from_sensor(boxes.boxes[i]) >= clearance) {
      candidates.add(row, sigmoid.data_ptr<double>()[row],
                     static_cast<int>(labels.data_ptr<std::int64_t>()[row]), boxes.boxes[i]);
    }
  }
  return candidates;
}

std::vector<std::int64_t> suppressed(const Candidates& candidates, const PostOptions& options) {
  return geometry::nms(candidates.boxes, candidates.scores,
                       {.threshold = options.nms_iou,
                        .class_aware = options.nms_class_aware,
                        .pre_limit = options.nms_candidates,
                        .post_limit = options.detections},
                       candidates.labels)
      .kept;
}

heads::HeadInput input_of(const Network& network, const RegionResults& results,
                          const Candidates& candidates, std::uint64_t seed) {
  const Tensor index = index_tensor(candidates.rows);
  const SecondStage second{results.second.features.index_select(0, index),
                           results.second.confidence.index_select(0, index),
                           results.second.residuals.index_select(0, index)};
  heads::HeadInput input =
      network.head_input(second, results.proposals.boxes.index_select(0, index));
  input.seed = seed;
  input.object_ids = index;
  return input;
}

/// Leaves out what has lost too much of its score; best score first.
void rank(std::vector<geometry::Detection>& detections, double least) {
  std::erase_if(detections, [&](const auto& detection) { return detection.score < least; });
  std::stable_sort(detections.begin(), detections.end(), [](const auto& first, const auto& second) {
    return first.score > second.score;
  });
}

geometry::Detection to_detection(const Candidates& candidates, std::size_t i,
                                 const geometry::Box& box, HeadAnswer& answer, std::int64_t row,
                                 const Options& options, const DetectionRequest& request,
                                 const evaluation::ConfidenceCalibration* calibration) {
  geometry::Detection detection;
  detection.label = options.classes[candidates.labels[i]];
  detection.score = candidates.scores[i];
  detection.box = box;
  heads::ObjectBoxes& object = answer.summary.objects[row];
  if (options.post.box == "quantile" && !object.quantile_boxes.empty()) {
    object.quantile_boxes.pop_back();
  }
  detection.quantile_boxes = object.quantile_boxes;
  if (answer.log_density.defined()) {
    // Boxes that the head's ranges do not hold have none.
    const double density = answer.log_density[row].item<double>();
    if (std::isfinite(density)) detection.log_density = density;
  }
  if (!answer.known_sizes.empty() && answer.known_sizes[row] != nullptr) {
    detection.known_size = *answer.known_sizes[row];
    // The same numbers before they were rounded to float.
    if (options.post.box != "quantile") detection.box.size = detection.known_size->size;
  }
  if (!answer.summary.single_box) detection.uncertainty = object.uncertainty;
  const auto& samples = answer.free_samples.empty() ? object.samples : answer.free_samples[row];
  if (!request.confidences.empty() && !samples.empty()) {
    detection.confidence_boxes = evaluation::confidence_boxes(
        *calibration, detection.label,
        {.boxes = samples, .object = static_cast<std::uint64_t>(candidates.rows[i])},
        request.confidences);
  }
  if (options.post.scoring == "overlap" && !object.samples.empty()) {
    detection.score *= geometry::overlapping_share({.boxes = object.samples}, detection.box,
                                                   options.post.overlap_iou);
  }
  if (request.samples) detection.samples = object.samples;
  return detection;
}

}  // namespace

DetectionResult to_detections(const Network& network, heads::BoxHead& head,
                              const RegionResults& results, const DetectionRequest& request,
                              const evaluation::ConfidenceCalibration* calibration) {
  const Options& options = network.options();
  DetectionResult result;
  const double least = std::max(options.post.score, request.score);
  Candidates candidates = scored(results, least, options.post.clearance, result.dropped_boxes);
  const bool decode_first = options.post.nms_on == "decoded";
  if (!decode_first) candidates = candidates.select(suppressed(candidates, options.post));
  if (candidates.rows.empty()) return result;
  const Tensor index = index_tensor(candidates.rows);
  const Tensor pointwise = decode_region_residuals(results.second.residuals.index_select(0, index),
                                                   results.proposals.boxes.index_select(0, index));
  HeadAnswer answer = ask(head, input_of(network, results, candidates, request.seed),
                          candidates.labels, pointwise, request, options);
  const UsableBoxes usable = usable_boxes(answer.boxes);
  result.dropped_boxes += usable.dropped;
  Candidates decoded = candidates.select(usable.rows);
  decoded.boxes = usable.boxes;
  std::vector<std::int64_t> kept(decoded.rows.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = static_cast<std::int64_t>(i);
  if (decode_first) kept = suppressed(decoded, options.post);
  for (const std::int64_t i : kept) {
    result.detections.push_back(to_detection(decoded, i, decoded.boxes[i], answer, usable.rows[i],
                                             options, request, calibration));
  }
  if (options.post.scoring == "overlap") rank(result.detections, least);
  return result;
}

}  // namespace arbox::detectors::pv_rcnn::internal
