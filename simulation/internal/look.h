#pragma once

#include "arbox/simulation/internal/daylight.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// The colours of an instance, as far as its materials leave them open.
struct Look {
  enum class Role { kWorld, kVehicle, kTram, kPerson } role = Role::kWorld;
  Rgb paint, cover, top, trousers, hair, skin, wall, roof, plant, wood;
};

/// Drawn from a stream of the instance's own; how light its paint is follows from its brightness,
/// which the laser sees too.
Look draw_look(const Scene& scene, std::size_t instance);

/// A colour made lighter or darker, no lighter than white paint.
Rgb scaled(const Rgb& color, double factor);

}  // namespace arbox::simulation
