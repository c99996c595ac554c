#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

enum class District { kInnerCity, kResidential, kRoad, kCampus, kHighway };

enum class Parking { kNone, kParallel, kOblique, kPerpendicular };

/// One side of the street, from the road outwards. Distances across the road are measured from the
/// own lane's middle, without sign.
struct RoadSide {
  double sign = 1.0;  ///< +1 left, -1 right.
  double edge = 2.0;  ///< Where the lanes end.
  Parking parking = Parking::kNone;
  double parking_width = 0.0;
  double curb = 0.08;  ///< Height, metres.
  double pavement = 2.0;
  double verge = 0.0;    ///< Grass between the pavement and the properties.
  double setback = 3.0;  ///< From the property line to the facade.
  double bank = 0.0;     ///< Slope of the ground beyond the property line.

  double curb_line() const { return edge + parking_width; }
  double property_line() const { return curb_line() + pavement + verge; }
  double facade_line() const { return property_line() + setback; }
};

/// A street that crosses ours or ends at it.
struct Crossing {
  double s = 0.0, half_width = 3.5;
  bool left = true, right = true;
};

/// The course of the road and the shape of the ground: s along the road (0 at the own vehicle), t
/// to the left of the own lane's middle.
struct Road {
  District district = District::kResidential;
  double lane_width = 3.2;
  int lanes_same = 1, lanes_opposite = 1;
  double curvature = 0.0;        ///< 1 / m, positive to the left.
  double sensor_height = 1.753;  ///< Over the road.
  double slope_x = 0.0117, slope_y = -0.009;
  double vertical_curvature = 0.0;  ///< 1 / m.
  double roughness = 1.0;
  RoadSide left, right;
  std::vector<Crossing> crossings;
  std::uint64_t seed = 0;

  Eigen::Vector2d position(double s, double t) const;
  double heading(double s) const { return curvature * s; }
  /// Height of the ground in the LiDAR frame.
  double height(double s, double t) const;
  const RoadSide& side(double t) const { return t > 0 ? left : right; }
  /// The crossing at s that opens to this side, or nullptr.
  const Crossing* crossing(double s, bool to_left, double margin = 0.0) const;
};

/// The ground as far as `reach` metres.
std::shared_ptr<const TriangleMesh> ground_mesh(const Road& road, double reach);

/// The lines that separate lanes, and those at the edges of larger roads.
RoadMarkings markings_of(const Road& road);

}  // namespace arbox::simulation
