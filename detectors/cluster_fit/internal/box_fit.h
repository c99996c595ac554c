#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "arbox/detectors/cluster_fit/internal/l_shape.h"
#include "arbox/detectors/cluster_fit/internal/occlusion.h"
#include "arbox/detectors/cluster_fit/internal/size_prior.h"
#include "arbox/geometry/box.h"

namespace arbox::detectors::internal {

/// What surrounds a cluster.
struct Surroundings {
  std::function<double(double x, double y)> ground;
  const OcclusionMap* occlusion = nullptr;
};

/// A cluster, its rectangle and what may be said of the object behind it.
struct FittedObject {
  /// Names its random numbers; depends on the cloud and on the options of clustering alone.
  std::uint64_t id = 0;
  const SizePrior* prior = nullptr;
  double score = 0.0;
  geometry::Box box = {};

  /// Means of the points in small squares of the xy plane.
  std::vector<Eigen::Vector2d> outline = {};
  Rectangle rectangle = {};
  /// Whether the end [axis][low, high] of the rectangle is where the object ends.
  std::array<std::array<bool, 2>, 2> end_seen = {};
  /// Height of the highest point, metres in the cloud's frame.
  double top = 0.0;
  /// Number of the rectangle's axis along the length, and the probability that it is axis 0.
  int length_axis = 0;
  double length_is_axis0 = 1.0;
};

/// Sorts out clusters that cannot be an object by their size alone.
bool larger_than_any_object(const Rectangle& rectangle);
bool larger_than_any_object(std::span<const Eigen::Vector3f> points);

/// Means of the points in squares of 0.1 m.
std::vector<Eigen::Vector2d> outline_of(std::span<const Eigen::Vector3f> points);

/// The best class and box for a cluster. Points must not be empty.
FittedObject fit_object(std::span<const Eigen::Vector3f> points,
                        std::vector<Eigen::Vector2d> outline, const Rectangle& rectangle,
                        const Surroundings& surroundings);

/// Boxes that the same object might have as well: points redrawn, hidden extents drawn from their
/// posterior. Draws depend on (seed, object.id) alone.
std::vector<geometry::Box> sample_boxes(const FittedObject& object, int count, std::uint64_t seed,
                                        const Surroundings& surroundings);

}  // namespace arbox::detectors::internal
