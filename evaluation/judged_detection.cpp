#include "arbox/evaluation/internal/judged_detection.h"

#include <cmath>
#include <string>

#include "arbox/base/error.h"
#include "arbox/evaluation/box_estimation.h"
#include "arbox/geometry/confidence_box.h"

namespace arbox::evaluation::internal {
namespace {

using geometry::Detection;

void require_finite(const std::optional<double>& uncertainty) {
  if (!uncertainty || std::isfinite(*uncertainty)) return;
  throw InvalidArgument("evaluate_uncertainty: expected a finite uncertainty, got " +
                        std::to_string(*uncertainty));
}

std::vector<geometry::ConfidenceBox> sample_boxes(const Detection& detection,
                                                  const UncertaintyOptions& options) {
  if (detection.samples.empty() || options.sample_confidences.empty()) return {};
  return geometry::confidence_boxes({.boxes = detection.samples}, options.sample_confidences);
}

}  // namespace

JudgedDetection judge(const Detection& detection, const Detection& object,
                      const UncertaintyOptions& options) {
  require_finite(detection.uncertainty);
  const geometry::BoxSamples samples{.boxes = detection.samples};
  JudgedDetection judged;
  const auto judge_box = [&](double level, const geometry::Box& box) {
    const BoxError error = box_error(box, object.box, geometry::BoxSymmetry::kHalfTurns);
    JudgedBox result{.level = level,
                     .iou = error.iou,
                     .iog = error.iog,
                     .f1 = error.f1,
                     .wrong_chance = {},
                     .held_share = {}};
    if (samples.boxes.empty()) return result;
    result.wrong_chance = 1.0 - geometry::overlapping_share(samples, box, options.wrong_iou);
    result.held_share = geometry::held_share(samples, box, options.min_iog);
    return result;
  };
  judged.uncertainty = detection.uncertainty;
  judged.own = judge_box(0.0, detection.box);
  for (const auto& one : detection.quantile_boxes) {
    judged.quantile_boxes.push_back(judge_box(one.q, one.box));
  }
  for (const auto& one : sample_boxes(detection, options)) {
    judged.sample_boxes.push_back(judge_box(one.p, one.box));
  }
  for (const auto& one : detection.confidence_boxes) {
    judged.confidence_boxes.push_back(judge_box(one.p, one.box));
  }
  if (samples.boxes.empty()) return judged;
  for (const double iou : options.promised_ious) {
    judged.overlap_shares.push_back(geometry::overlapping_share(samples, detection.box, iou));
  }
  return judged;
}

}  // namespace arbox::evaluation::internal
