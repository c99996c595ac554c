#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "arbox/detectors/cluster_fit/internal/l_shape.h"
#include "arbox/detectors/cluster_fit/internal/occlusion.h"
#include "arbox/detectors/cluster_fit/internal/size_prior.h"

/// \file
/// How well classes of known sizes explain a cluster.

namespace arbox::detectors::internal {

/// What surrounds a cluster.
struct Surroundings {
  std::function<double(double x, double y)> ground;
  const OcclusionMap* occlusion = nullptr;
};

/// Whether the end [axis][low, high] of a rectangle is where the object ends.
using EndsSeen = std::array<std::array<bool, 2>, 2>;

/// One rectangle that may be the outline of an object.
struct Hypothesis {
  Rectangle rectangle = {};
  EndsSeen end_seen = {};
  /// Number of the rectangle's axis along the length, and the probability that it is axis 0.
  int length_axis = 0;
  double length_is_axis0 = 1.0;
  /// Its share among the hypotheses of an object.
  double share = 1.0;
};

/// What the extents of a rectangle tell of the sizes of a class.
struct Explanation {
  SizePosterior length, width, height;
  double log_evidence() const {
    return length.log_evidence() + width.log_evidence() + height.log_evidence();
  }
};

/// The sizes of the class, with the length along one of the rectangle's axes.
Explanation explain(const SizePrior& prior, const Hypothesis& hypothesis, int length_axis,
                    double height);

/// Height of `top` above the ground in the middle of the rectangle, above zero.
double height_above_ground(double top, const Rectangle& rectangle,
                           const Surroundings& surroundings);

/// How well each class explains a cluster with one rectangle around it.
struct Judgement {
  Rectangle rectangle;
  EndsSeen end_seen = {};
  double height = 0.0;
  /// Of each class, with the length along axis 0 and along axis 1.
  std::array<std::array<double, 2>, kSizePriors.size()> evidence = {};

  double sum(std::size_t prior) const { return evidence[prior][0] + evidence[prior][1]; }
  /// Of all classes and of clutter.
  double total() const;
  /// Of the class and of the rectangle.
  double likelihood(std::size_t prior) const;
};

/// Judges a rectangle around `count` points whose highest is at `top`.
Judgement judge(const Rectangle& rectangle, std::size_t count, double top,
                const Surroundings& surroundings);

/// The rectangles that the class allows as shares of the likelihood, `best` first.
std::vector<Hypothesis> worth_a_draw(const std::vector<Judgement>& judgements, std::size_t best,
                                     std::size_t prior);

/// Deviation of measured heights, metres.
inline constexpr double kGroundNoise = 0.05;
/// Measured spread of where the returns of one face begin (mirrors and bumpers stick out).
inline constexpr double kExtentNoise = 0.06;

}  // namespace arbox::detectors::internal
