#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "arbox/detectors/cluster_fit/internal/evidence.h"
#include "arbox/geometry/box.h"

namespace arbox::detectors::internal {

/// A cluster and what may be said of the object behind it.
struct FittedObject {
  /// Names its random numbers; depends on the cloud and on the options of clustering alone.
  std::uint64_t id = 0;
  const SizePrior* prior = nullptr;
  double score = 0.0;
  geometry::Box box = {};

  /// Means of the points in small squares of the xy plane.
  std::vector<Eigen::Vector2d> outline = {};
  /// The rectangle of the box first, then others worth a draw.
  std::vector<Hypothesis> hypotheses = {};
  /// Height of the highest point, metres in the cloud's frame.
  double top = 0.0;
};

/// The class, rectangle and box that explain a cluster best. Neither points nor rectangles must be
/// empty.
FittedObject fit_object(std::span<const Eigen::Vector3f> points,
                        std::vector<Eigen::Vector2d> outline, std::span<const Rectangle> rectangles,
                        const Surroundings& surroundings);

/// Boxes that the same object might have as well: the rectangle drawn, points redrawn, hidden
/// extents drawn from their posterior. Draws depend on (seed, object.id) alone.
std::vector<geometry::Box> sample_boxes(const FittedObject& object, int count, std::uint64_t seed,
                                        const Surroundings& surroundings);

}  // namespace arbox::detectors::internal
