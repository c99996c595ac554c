#pragma once

#include <vector>

#include "arbox/simulation/internal/daylight.h"
#include "arbox/simulation/ray_tracer.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// What surfaces of a scene look like. Colours of an instance are drawn from streams of its own;
/// how light its paint is follows from its brightness, which the laser sees too.
class SurfaceColors {
 public:
  explicit SurfaceColors(const Scene& scene);

  /// Diffuse reflectance where a ray met the scene; glass has none.
  Rgb color(const Hit& hit, const Eigen::Vector3d& point) const;

 private:
  struct Look {
    enum class Role { kWorld, kVehicle, kTram, kPerson } role = Role::kWorld;
    Rgb paint, cover, top, trousers, hair, skin, wall, roof, plant, wood;
  };
  static Look draw_look(const Scene& scene, std::size_t instance);

  Rgb ground(const Hit& hit, const Eigen::Vector3d& point) const;
  Rgb person(const Look& look, const Hit& hit, const Eigen::Vector3d& place) const;
  Rgb vehicle(const Look& look, const Hit& hit, const Eigen::Vector3d& place) const;
  Rgb thing(const Look& look, const Hit& hit, const Eigen::Vector3d& point) const;
  Rgb sign(const Hit& hit, const Eigen::Vector3d& point) const;

  const Scene& scene_;
  std::vector<Look> looks_;
};

}  // namespace arbox::simulation
