#pragma once

#include <vector>

#include "arbox/simulation/internal/look.h"
#include "arbox/simulation/ray_tracer.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// What surfaces of a scene look like.
class SurfaceColors {
 public:
  explicit SurfaceColors(const Scene& scene);

  /// Diffuse reflectance where a ray met the scene; glass has none.
  Rgb color(const Hit& hit, const Eigen::Vector3d& point) const;

 private:
  Rgb ground(const Hit& hit, const Eigen::Vector3d& point) const;
  Rgb person(const Look& look, const Hit& hit, const Eigen::Vector3d& place) const;
  Rgb vehicle(const Look& look, const Hit& hit, const Eigen::Vector3d& place) const;
  Rgb thing(const Look& look, const Hit& hit, const Eigen::Vector3d& point) const;
  Rgb sign(const Hit& hit, const Eigen::Vector3d& point) const;

  const Scene& scene_;
  std::vector<Look> looks_;
};

}  // namespace arbox::simulation
