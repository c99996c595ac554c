#pragma once

#include "arbox/base/random.h"
#include "arbox/simulation/internal/mesh_builder.h"
#include "arbox/simulation/models.h"

namespace arbox::simulation {

/// Numbers of one shape, taken one after the other.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t object, std::uint32_t purpose)
      : random_(seed, object, purpose) {}
  float uniform(double low, double high) {
    return static_cast<float>(random_.uniform(next_++, low, high));
  }
  float normal(double mean, double deviation) {
    return static_cast<float>(mean + deviation * random_.normal(next_++));
  }
  bool chance(double probability) { return random_.uniform(next_++) < probability; }
  int below(int count) {
    return static_cast<int>(random_.below(next_++, static_cast<std::uint32_t>(count)));
  }

 private:
  RandomStream random_;
  std::uint32_t next_ = 0;
};

/// Each builds a shape that stands on z = 0. `overhang` collects what may leave the nominal box.
void build_vehicle(ModelKind kind, Dice& dice, MeshBuilder& body, MeshBuilder& overhang);
void build_truck(Dice& dice, bool articulated, MeshBuilder& body, MeshBuilder& overhang);
void build_tram(Dice& dice, MeshBuilder& body);
void build_trailer(Dice& dice, MeshBuilder& body);
void build_pedestrian(Dice& dice, MeshBuilder& body);
void build_person_sitting(Dice& dice, MeshBuilder& body);
void build_cyclist(Dice& dice, MeshBuilder& body);
void build_bicycle(Dice& dice, MeshBuilder& body);
void build_plant(ModelKind kind, Dice& dice, MeshBuilder& body);
void build_furniture(ModelKind kind, Dice& dice, MeshBuilder& body);
void build_building(ModelKind kind, Dice& dice, MeshBuilder& body);

}  // namespace arbox::simulation
