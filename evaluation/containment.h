#pragma once

#include <optional>
#include <span>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/quantile_box.h"

/// \file
/// Whether boxes hold what they promise: mean overlap with the truth, and how often a quantile box
/// contains the object (Liu et al., ECCV 2022, sections 4.2 and 5.2).

namespace arbox::evaluation {

/// Overlap of predicted with true boxes, averaged over objects. IoG is the share of the true box
/// that the prediction covers.
struct MeanOverlap {
  double iou = 0.0;
  double iog = 0.0;
};

/// Means over predictions[i], truth[i]; empty for no pairs. Throws InvalidArgument if the lengths
/// differ or a box is invalid.
std::optional<MeanOverlap> mean_overlap(std::span<const geometry::Box> predictions,
                                        std::span<const geometry::Box> truth);

/// The share of a true box that counts as containing it (paper, section 5.2).
inline constexpr double kContainedIog = geometry::kHeldIog;

/// Share of the pairs whose IoG is above min_iog; empty for no pairs. Throws as mean_overlap does.
std::optional<double> contained_fraction(std::span<const geometry::Box> predictions,
                                         std::span<const geometry::Box> truth,
                                         double min_iog = kContainedIog);

/// Promise and fact of quantile boxes at one q.
struct ContainmentPoint {
  double q = 0.0;
  /// 1 - q: the probability of containing the object where the predicted distribution is right
  /// (paper, theorem 1).
  double promised = 1.0;
  double contained = 0.0;
};

/// One point for each place in the objects' lists of quantile boxes; empty for no objects.
///
/// Throws InvalidArgument if objects and truth differ in number, or objects differ in their q.
std::vector<ContainmentPoint> containment_curve(
    std::span<const std::vector<geometry::QuantileBox>> objects,
    std::span<const geometry::Box> truth, double min_iog = kContainedIog);

}  // namespace arbox::evaluation
