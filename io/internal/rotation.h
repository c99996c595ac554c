#pragma once

#include <cmath>
#include <optional>

#include "arbox/geometry/box.h"

namespace arbox::io::internal {

/// A quaternion of a file: normalised if its norm is 1 within 1e-3, nothing otherwise. What is
/// already of unit norm to rounding stays as it is, so that files round-trip.
inline std::optional<geometry::Quaternion> accepted_rotation(const geometry::Quaternion& q) {
  const double error = std::abs(q.norm() - 1.0);
  if (!(error <= 1e-3)) return std::nullopt;
  return error <= 1e-15 ? q : geometry::Quaternion(q.normalized());
}

}  // namespace arbox::io::internal
