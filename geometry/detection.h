#pragma once

#include <optional>
#include <string>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/known_size.h"
#include "arbox/geometry/quantile_box.h"

namespace arbox::geometry {

/// One object that a detector found, in the frame of the cloud that it was given.
/// What was not asked for, or does not apply to the detector's head, is empty.
struct Detection {
  std::string label;
  /// Confidence in [0, 1].
  double score = 0.0;
  Box box;
  /// Quantile boxes in the order asked for (paper, section 4.2).
  std::vector<QuantileBox> quantile_boxes;
  /// Calibrated boxes that contain the object with probability p, in the order asked for.
  std::vector<ConfidenceBox> confidence_boxes;
  /// Log density of `box` under the head's distribution, per unit component volume.
  std::optional<double> log_density;
  /// U(a, b) = 1 - IoU of two quantile boxes (paper, section 4.3), in [0, 1].
  std::optional<double> uncertainty;
  /// The known size that dimension conditioning chose.
  std::optional<KnownSize> known_size;
  /// Draws from the head's distribution, kept when asked for.
  std::vector<Box> samples;
};

}  // namespace arbox::geometry
