#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "arbox/evaluation/containment.h"
#include "arbox/geometry/box.h"
#include "arbox/geometry/rotation.h"

/// \file
/// How far estimated boxes are from the true ones, object by object: the metrics of the bin-picking
/// experiments (Liu et al., ECCV 2022, section 5.2). Prediction i belongs to truth i; who matches
/// them is the caller.

namespace arbox::evaluation {

/// Differences of one box and the true one.
struct BoxError {
  /// Intersection over union and over the true volume, exact, 0..1.
  double iou = 0.0, iog = 0.0;
  /// 2 IoU IoG / (IoU + IoG), 0 if both are 0.
  double f1 = 0.0;
  /// Least sum of the differences of sizes over the 6 orders of the predicted ones, metres.
  double dimensions = 0.0;
  /// Least angle over the renamings of axes, radians.
  double quaternion = 0.0;
  /// Distance of the centres, metres.
  double center = 0.0;
};

/// `symmetry` says which renamings of axes count as the same rotation; sizes may come in any order
/// whatever it is. Throws InvalidArgument for invalid boxes.
BoxError box_error(const geometry::Box& predicted, const geometry::Box& truth,
                   geometry::BoxSymmetry symmetry = geometry::BoxSymmetry::kFrame);

struct BoxEstimationOptions {
  /// kFrame: the 24 proper rotations of a box; kHalfTurns: 4; kNone: a box with a front.
  geometry::BoxSymmetry symmetry = geometry::BoxSymmetry::kFrame;
  /// A box contains its object if their IoG is above this.
  double min_iog = kContainedIog;
  /// 0 means default_threads().
  int threads = 0;
};

struct BoxEstimationReport {
  std::size_t objects = 0;
  /// Means over the objects; 0 without objects.
  BoxError mean;
  /// F1 of the mean IoU and the mean IoG: most rows of the paper's table are this one.
  double f1_of_means = 0.0;
  /// The mean of each object's F1 is mean.f1. Share of objects whose IoG is above min_iog.
  double contained = 0.0;
};

/// Errors of many boxes. The result does not depend on `threads`. Throws InvalidArgument for spans
/// of different lengths and for invalid boxes, naming the row. About a microsecond a pair.
BoxEstimationReport evaluate_boxes(std::span<const geometry::Box> predicted,
                                   std::span<const geometry::Box> truth,
                                   const BoxEstimationOptions& options = {});

/// {"protocol": "boxes", "objects": 3, "mean_iou": ..., "mean_iog": ..., "f1_of_means": ...,
///  "mean_f1": ..., "err_dim": ..., "err_quat": ..., "err_center": ..., "contained": ...}
std::string to_json(const BoxEstimationReport& report);

/// Lines for a terminal.
std::string to_table(const BoxEstimationReport& report);

}  // namespace arbox::evaluation
