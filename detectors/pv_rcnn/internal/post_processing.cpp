#include "arbox/detectors/pv_rcnn/internal/post_processing.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/isfinite.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <cmath>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/box_rows.h"
#include "arbox/geometry/nms.h"
#include "arbox/heads/conditioning.h"
#include "arbox/heads/distribution_boxes.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

using at::Tensor;

Tensor index_tensor(const std::vector<std::int64_t>& index) {
  Tensor result = at::empty({std::ssize(index)}, at::kLong);
  std::copy(index.begin(), index.end(), result.data_ptr<std::int64_t>());
  return result;
}

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

/// Regions with finite numbers and a score of at least `score`, with their pointwise boxes.
Candidates scored(const RegionResults& results, double score, std::int64_t& dropped) {
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
    } else if (sigmoid.data_ptr<double>()[row] >= score) {
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

/// The head's answer for candidates.
struct Answer {
  Tensor boxes;        // (N, 7)
  Tensor log_density;  // (N) or undefined
  heads::DistributionBoxes summary;
  /// By candidate, null without one; empty if none is asked for.
  std::vector<const geometry::KnownSize*> known_sizes;
  /// By candidate: draws of objects of unknown size, if `summary` has others.
  std::vector<std::vector<geometry::Box>> free_samples;
};

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

Tensor quantile_rows(const heads::DistributionBoxes& summary, const Tensor& fallback) {
  Tensor rows = fallback.clone();
  for (std::size_t i = 0; i < summary.objects.size(); ++i) {
    if (summary.objects[i].quantile_boxes.empty()) continue;
    const geometry::Box& box = summary.objects[i].quantile_boxes.back().box;
    const double numbers[] = {box.center.x(), box.center.y(), box.center.z(),    box.size.x(),
                              box.size.y(),   box.size.z(),   geometry::yaw(box)};
    for (std::int64_t k = 0; k < kBoxNumbers; ++k) rows[i][k] = numbers[k];
  }
  return rows;
}

bool needs_draws(const DetectionRequest& request, const PostOptions& options) {
  return request.uncertainty || request.samples || options.box == "quantile" ||
         !request.quantiles.empty() || !request.confidences.empty();
}

/// Boxes and what draws tell.
Answer boxes_of(const heads::BoxDistribution& distribution, const heads::Streams& streams,
                const Tensor& pointwise, const DetectionRequest& request,
                const PostOptions& options) {
  Answer answer;
  heads::DistributionBoxOptions wanted;
  wanted.samples = options.samples;
  wanted.quantiles = request.quantiles;
  wanted.threads = request.threads;
  // The box itself, if it is a quantile box, comes last.
  if (options.box == "quantile") wanted.quantiles.push_back(options.quantile);
  answer.summary.objects.resize(distribution.size());
  if (needs_draws(request, options)) {
    answer.summary = heads::distribution_boxes(distribution, streams, wanted);
  }
  if (options.box == "pointwise") {
    answer.boxes = pointwise;
  } else if (options.box == "mean") {
    answer.boxes = from_box_rows(distribution.mean());
  } else if (options.box == "quantile") {
    answer.boxes = quantile_rows(answer.summary, pointwise);
  } else {
    answer.boxes = from_box_rows(distribution.mode(options.beam_width).boxes.select(1, 0));
  }
  return answer;
}

/// Which known size each of a distribution's objects has; null where none is possible.
std::vector<const geometry::KnownSize*> chosen_sizes(const heads::BoxDistribution& distribution,
                                                     const std::vector<geometry::KnownSize>& known,
                                                     const PostOptions& options) {
  std::vector<const geometry::KnownSize*> chosen;
  for (const heads::ConditionedBox& one : heads::given_known_sizes(
           distribution, known,
           {.beam_width = options.beam_width, .score = options.known_sizes, .orders = "given"})) {
    chosen.push_back(std::isfinite(one.log_density) ? &known[one.known_size] : nullptr);
  }
  return chosen;
}

Tensor size_rows(const std::vector<const geometry::KnownSize*>& sizes) {
  Tensor rows = at::zeros({std::ssize(sizes), 3}, at::kDouble);
  double* number = rows.data_ptr<double>();
  for (const geometry::KnownSize* known : sizes) {
    for (const double extent : known->size) *number++ = extent;
  }
  return rows;
}

/// Puts what objects of known size look like in the place of what is known without.
void condition(const heads::BoxDistribution& distribution, const heads::Streams& streams,
               const Tensor& pointwise, const std::vector<std::int64_t>& rows,
               const std::vector<geometry::KnownSize>& known, const DetectionRequest& request,
               const PostOptions& options, Answer& answer) {
  const auto chosen = chosen_sizes(*distribution.select(index_tensor(rows)), known, options);
  std::vector<std::int64_t> sized;
  std::vector<const geometry::KnownSize*> sizes;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (chosen[i] == nullptr) continue;
    sized.push_back(rows[i]);
    sizes.push_back(chosen[i]);
  }
  if (sized.empty()) return;
  const Tensor index = index_tensor(sized);
  Answer given = boxes_of(*distribution.select(index)->given_sizes(size_rows(sizes)),
                          {streams.seed, streams.object_ids.index_select(0, index)},
                          pointwise.index_select(0, index), request, options);
  answer.boxes = answer.boxes.index_copy(0, index, given.boxes.to(answer.boxes.scalar_type()));
  for (std::size_t i = 0; i < sized.size(); ++i) {
    answer.known_sizes[sized[i]] = sizes[i];
    answer.summary.objects[sized[i]] = std::move(given.summary.objects[i]);
  }
}

std::vector<std::int64_t> rows_of_class(const Candidates& candidates, std::int64_t label) {
  std::vector<std::int64_t> rows;
  for (std::size_t i = 0; i < candidates.labels.size(); ++i) {
    if (candidates.labels[i] == label) rows.push_back(static_cast<std::int64_t>(i));
  }
  return rows;
}

Answer ask(heads::BoxHead& head, const heads::HeadInput& input, const Candidates& candidates,
           const Tensor& pointwise, const DetectionRequest& request, const Options& options) {
  const auto distribution = head.forward(input);
  const heads::Streams streams = input.streams();
  Answer answer = boxes_of(*distribution, streams, pointwise, request, options.post);
  if (!request.known_sizes.empty()) {
    answer.known_sizes.resize(candidates.rows.size());
    for (const auto& object : answer.summary.objects) {
      if (!request.confidences.empty()) answer.free_samples.push_back(object.samples);
    }
  }
  for (const auto& [name, known] : request.known_sizes) {
    const auto label = std::find(options.classes.begin(), options.classes.end(), name);
    const auto rows = rows_of_class(candidates, label - options.classes.begin());
    if (rows.empty()) continue;
    condition(*distribution, streams, pointwise, rows, known, request, options.post, answer);
  }
  if (distribution->measure() == heads::Measure::kDensity) {
    answer.log_density = distribution->log_density(to_box_rows(answer.boxes)).to(at::kDouble);
  }
  return answer;
}

geometry::Detection to_detection(const Candidates& candidates, std::size_t i,
                                 const geometry::Box& box, Answer& answer, std::int64_t row,
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
  if (request.samples) detection.samples = object.samples;
  return detection;
}

}  // namespace

DetectionResult to_detections(const Network& network, heads::BoxHead& head,
                              const RegionResults& results, const DetectionRequest& request,
                              const evaluation::ConfidenceCalibration* calibration) {
  const Options& options = network.options();
  DetectionResult result;
  Candidates candidates =
      scored(results, std::max(options.post.score, request.score), result.dropped_boxes);
  const bool decode_first = options.post.nms_on == "decoded";
  if (!decode_first) candidates = candidates.select(suppressed(candidates, options.post));
  if (candidates.rows.empty()) return result;
  const Tensor index = index_tensor(candidates.rows);
  const Tensor pointwise = decode_region_residuals(results.second.residuals.index_select(0, index),
                                                   results.proposals.boxes.index_select(0, index));
  Answer answer = ask(head, input_of(network, results, candidates, request.seed), candidates,
                      pointwise, request, options);
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
  return result;
}

}  // namespace arbox::detectors::pv_rcnn::internal
