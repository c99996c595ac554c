#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

namespace arbox::detectors::internal {

/// How the sizes of a class are distributed, and how far its returns stop short of a visible end.
struct SizePrior {
  std::string_view label;
  /// Length, width, height, metres.
  Eigen::Vector3d mean, deviation;
  /// Mean distance between the outermost return and a visible end (exponential).
  Eigen::Vector3d slack;
  /// Median of the number of returns times the squared distance (64-beam scanner), and the
  /// deviation of its logarithm, widened for what hides part of the object.
  double returns, returns_deviation;
  /// How common the class is among the three.
  double share;
  /// Front and rear slope, flanks do not.
  bool sloping_ends;
};

/// Means and deviations of all labels of the KITTI object training set (7481 frames: 28742 cars,
/// 4487 pedestrians, 1627 cyclists); slack and returns from the labelled objects of 25 of its
/// scans.
inline const std::array<SizePrior, 3> kSizePriors = {{
    {"Car",
     {3.884, 1.629, 1.526},
     {0.426, 0.102, 0.137},
     {0.20, 0.08, 0.08},
     94000,
     0.9,
     0.82,
     true},
    {"Pedestrian",
     {0.842, 0.660, 1.761},
     {0.235, 0.143, 0.113},
     {0.25, 0.15, 0.13},
     36000,
     0.7,
     0.13,
     false},
    {"Cyclist",
     {1.764, 0.597, 1.737},
     {0.177, 0.124, 0.095},
     {0.15, 0.12, 0.13},
     42000,
     0.7,
     0.05,
     false},
}};

/// What is known of one size once an extent of it was seen: the prior, cut below the extent and, if
/// both ends were visible, weighted by exp(-(size - extent) / slack). This is a truncated normal.
class SizePosterior {
 public:
  /// `noise` is the standard deviation of the measured extent.
  SizePosterior(double mean, double deviation, double slack, double extent, bool ends_visible,
                double noise);

  /// Log of the density of the extent under the class: how well the class explains it.
  double log_evidence() const { return log_evidence_; }
  /// Expectation of the size; never below the extent.
  double mean() const;
  /// The size below which the share u in [0, 1) of the posterior lies; never below the extent.
  double quantile(double u) const;

 private:
  double centre_, deviation_, extent_;
  double log_evidence_;
};

}  // namespace arbox::detectors::internal
