#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "arbox/geometry/detection.h"
#include "arbox/geometry/point_cloud_view.h"
#include "support/convex.h"

/// \file
/// A made street and a made 64-beam scanner in it: exact labels for tests and for the scan in
/// examples/data. LiDAR frame, sensor at the origin.

namespace arbox::testing {

struct StreetOptions {
  std::uint64_t seed = 1;
  /// Rise over run of the road ahead, and of the ground to the left.
  double slope_x = 0.02, slope_y = 0.01;
  double azimuth_step = 0.25;
  /// Half of the horizontal field of view, degrees.
  double half_view = 180.0;
  /// Multiplies every noise of the scanner.
  double noise = 1.0;
  double sensor_height = 1.73;
};

struct StreetScene {
  geometry::PointCloud cloud;
  /// Label and tight box of each object; the score is 1.
  std::vector<geometry::Detection> truth;
  /// How many returns each of them has.
  std::vector<int> returns;
  /// The share of the rays that would meet it alone which do meet it first, in [0, 1].
  std::vector<double> visible;
};

/// The whole street: parked and moving cars, persons, cyclists, walls, trees, poles, kerbs.
StreetScene make_street(const StreetOptions& options = {});

/// What a scanner sees. Solids with `owner` >= 0 belong to truth[owner].
struct OwnedConvex {
  Convex solid;
  int owner = -1;
};
using GroundHeight = std::function<double(double x, double y)>;
StreetScene scan(const std::vector<OwnedConvex>& solids, std::vector<geometry::Detection> truth,
                 const GroundHeight& ground, const StreetOptions& options);

/// Solids of one object whose tight box is `box`.
std::vector<Convex> car_solids(const geometry::Box& box);
std::vector<Convex> pedestrian_solids(const geometry::Box& box);
std::vector<Convex> cyclist_solids(const geometry::Box& box);

}  // namespace arbox::testing
