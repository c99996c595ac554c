#pragma once

#include <optional>
#include <vector>

#include "arbox/evaluation/uncertainty_protocol.h"

namespace arbox::evaluation::internal {

/// A box of a detection beside the object that the detection found.
struct JudgedBox {
  /// q of a quantile box, p of a confidence box, 0 of the detection's own.
  double level = 0.0;
  double iou = 0.0, iog = 0.0, f1 = 0.0;
  /// The share of the detection's samples whose IoU with the box is below wrong_iou: the chance
  /// that the box is wrong, as far as they know. Empty without samples.
  std::optional<double> wrong_chance;
  /// The share of the samples that the box contains (by min_iog). Empty without samples.
  std::optional<double> held_share;
};

struct JudgedDetection {
  std::optional<double> uncertainty;
  JudgedBox own;
  std::vector<JudgedBox> quantile_boxes, sample_boxes, confidence_boxes;
  /// The shares of the samples that overlap the own box by promised_ious; empty without samples.
  std::vector<double> overlap_shares;
};

/// Throws InvalidArgument for invalid boxes and an uncertainty that is not finite.
JudgedDetection judge(const geometry::Detection& detection, const geometry::Detection& object,
                      const UncertaintyOptions& options);

}  // namespace arbox::evaluation::internal
