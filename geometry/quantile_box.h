#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "arbox/geometry/box.h"

/// \file
/// Occupancy and quantile boxes of sampled boxes (paper, section 4.2 and appendix B). The samples
/// may come from any source: a head's distribution, or an ensemble of other detectors.

namespace arbox::geometry {

/// The minimum-volume box over the points whose occupancy is above q.
struct QuantileBox {
  double q = 0.0;
  Box box;
  /// True if no point had an occupancy above q, so that `box` came from the documented fallback.
  bool fallback = false;
};

/// A box that contains the object with probability p.
struct ConfidenceBox {
  double p = 0.0;
  Box box;
};

}  // namespace arbox::geometry
