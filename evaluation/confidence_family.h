#pragma once

#include <span>
#include <vector>

#include "arbox/evaluation/containment.h"
#include "arbox/geometry/quantile_box.h"

/// \file
/// The boxes among which a confidence box is chosen: quantile boxes of one object for a q that
/// falls to 0, then the q = 0 box grown about its centre.
///
/// One number tells them apart, the extent: up to 1 it is 1 - q, above 1 the factor by which the
/// q = 0 box is grown. Between the 1 - q of two boxes faces go from the one to the other in
/// proportion (geometry::box_between). A box of larger extent contains all of smaller extent, so
/// that "contains the object" can only become true as the extent rises. Quantile boxes alone need
/// not be nested (their rotations differ); where one does not contain the one before, the smallest
/// box around both in either's rotation takes its place.

namespace arbox::evaluation {

struct ConfidenceFamilyOptions {
  /// Falling, in [0, 1), the last one 0. The last ones are as close as 64 samples can tell apart:
  /// many objects need one of these.
  std::vector<double> quantiles = {0.95, 0.90, 0.85, 0.80, 0.75, 0.70, 0.65, 0.60, 0.55,
                                   0.50, 0.45, 0.40, 0.35, 0.30, 0.25, 0.20, 0.15, 0.12,
                                   0.10, 0.08, 0.07, 0.05, 0.04, 0.02, 0.0};
  /// How the quantile boxes are made.
  geometry::QuantileOptions quantile_box = {};
};

/// Throws InvalidArgument unless the quantiles are as documented.
void require_valid(const ConfidenceFamilyOptions& options);

/// The nested boxes of one object. A value; copies are independent.
class ConfidenceFamily {
 public:
  /// Throws InvalidArgument for bad samples (geometry::quantile_boxes) and options.
  explicit ConfidenceFamily(const geometry::BoxSamples& samples,
                            const ConfidenceFamilyOptions& options = {});

  /// The box of an extent; the smallest one for all below its 1 - q. Throws InvalidArgument unless
  /// the extent is above 0 and finite.
  geometry::Box box(double extent) const;

  /// The least extent whose box covers more than min_iog of `truth`: from one 1 - q to the next in
  /// eight steps, or a factor from 1.01 to 10 in steps of 0.01; infinity if even the factor 10 is
  /// too small. Throws InvalidArgument for an invalid box.
  double extent_containing(const geometry::Box& truth, double min_iog = kContainedIog) const;

 private:
  std::vector<double> extents_;
  std::vector<geometry::Box> boxes_;
};

}  // namespace arbox::evaluation
