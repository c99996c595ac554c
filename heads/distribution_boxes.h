#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/heads/box_distribution.h"

/// \file
/// From distributions over boxes to quantile boxes, confidence boxes and uncertainty (paper,
/// sections 4.2 and 4.3).

namespace arbox::heads {

struct DistributionBoxOptions {
  /// Draws from each object's distribution.
  int samples = 64;
  double temperature = 1.0;
  /// Quantile boxes wanted, in the order of the result.
  std::vector<double> quantiles = {};
  /// Confidence boxes wanted (geometry::confidence_boxes), in the order of the result.
  std::vector<double> confidences = {};
  /// U(a, b) = 1 - IoU of the quantile boxes a and b.
  double uncertainty_first = 0.2, uncertainty_second = 0.8;
  int points_per_box = 64;
  int threads = 0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("samples", &DistributionBoxOptions::samples,
                  {.help = "Draws from each object's distribution", .low = 1, .high = 1e6});
    visitor.field("temperature", &DistributionBoxOptions::temperature,
                  {.help = "Below 1 draws likelier boxes, above 1 more varied ones", .low = 1e-6});
    visitor.field("quantiles", &DistributionBoxOptions::quantiles,
                  {.help = "Quantile boxes wanted", .low = 0, .high = 1});
    visitor.field("confidences", &DistributionBoxOptions::confidences,
                  {.help = "Confidence boxes wanted", .low = 0, .high = 1});
    visitor.field("uncertainty_first", &DistributionBoxOptions::uncertainty_first,
                  {.help = "First quantile of the uncertainty", .low = 0, .high = 1});
    visitor.field("uncertainty_second", &DistributionBoxOptions::uncertainty_second,
                  {.help = "Second quantile of the uncertainty", .low = 0, .high = 1});
    visitor.field(
        "points_per_box", &DistributionBoxOptions::points_per_box,
        {.help = "Points drawn in every sample", .unit = "points", .low = 0, .high = 1e6});
    visitor.field("threads", &DistributionBoxOptions::threads,
                  {.help = "Threads; 0 means the program's default", .low = 0, .high = 1024});
  }
};

/// What one object's draws say. Empty, without uncertainty, if no draw was usable.
struct ObjectBoxes {
  std::vector<geometry::Box> samples;  ///< The usable draws.
  std::vector<geometry::QuantileBox> quantile_boxes;
  std::vector<geometry::ConfidenceBox> confidence_boxes;
  std::optional<double> uncertainty;  ///< In [0, 1].
  /// Draws left out because a number was not finite or a size not above zero.
  std::int64_t dropped = 0;
};

struct DistributionBoxes {
  std::vector<ObjectBoxes> objects;
  /// Sum of the objects' dropped draws.
  std::int64_t dropped = 0;
  /// The head has no distribution (Measure::kNone): every box of an object is its one box and its
  /// uncertainty of 0 says nothing.
  bool single_box = false;
};

/// Draws boxes from every object's distribution and sums them up. An object's result depends on
/// (streams.seed, its id) and not on the batch. No objects: no results. Errors: those of sample()
/// and of geometry::quantile_boxes, ConfigError for bad options.
DistributionBoxes distribution_boxes(const BoxDistribution& distribution, const Streams& streams,
                                     const DistributionBoxOptions& options = {});

}  // namespace arbox::heads
