#pragma once

#include <string>
#include <vector>

#include "arbox/simulation/internal/model_builders.h"
#include "arbox/simulation/internal/road.h"
#include "arbox/simulation/scene.h"
#include "arbox/simulation/street.h"

namespace arbox::simulation {

/// A place in the street: along the road, to the left, and the turn against the road's heading.
struct Spot {
  double s = 0.0, t = 0.0, turn = 0.0;
};

/// Fills a scene; keeps things apart.
class StreetBuilder {
 public:
  StreetBuilder(const Road& road, Dice& dice, Scene& scene);

  const Road& road() const { return road_; }
  Dice& dice() { return dice_; }
  Scene& scene() { return scene_; }

  /// Adds a labelled object of this size that stands on the ground. False if something is there.
  bool add_object(const std::string& label, ModelKind kind, int variant,
                  const Eigen::Vector3d& size, const Spot& spot, double speed, double brightness);
  /// Adds a vehicle of a class, its shape, size and paint drawn.
  bool add_vehicle(const std::string& label, const Spot& spot, double speed);
  bool add_person(const std::string& label, const Spot& spot, double speed);

  /// Adds a thing without a label, stretched by `scale`. False if it needs room that is taken.
  bool add_thing(ModelKind kind, const Spot& spot, const Eigen::Vector3d& scale,
                 bool needs_room = true, double sink = 0.0);
  bool add_thing(ModelKind kind, const Spot& spot) {
    return add_thing(kind, spot, Eigen::Vector3d::Ones());
  }

 private:
  struct Footprint {
    Eigen::Vector2d center, half;
    double yaw;
  };
  static bool overlap(const Footprint& a, const Footprint& b, double margin);
  bool claim(const Footprint& footprint, double margin);

  const Road& road_;
  Dice& dice_;
  Scene& scene_;
  std::vector<Footprint> taken_;
};

void add_traffic(StreetBuilder& builder, const StreetOptions& options);
void add_people(StreetBuilder& builder, const StreetOptions& options);
void add_sides(StreetBuilder& builder);

}  // namespace arbox::simulation
