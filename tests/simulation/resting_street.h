#pragma once

#include <cstdint>

#include "arbox/simulation/street.h"

namespace arbox::simulation {

/// A made street in which nothing moves.
inline Scene resting_street(std::uint64_t seed, std::uint64_t index) {
  Scene scene = street_scene({}, seed, index);
  scene.ego = {};
  for (SceneObject& object : scene.objects) object.velocity.setZero();
  return scene;
}

}  // namespace arbox::simulation
