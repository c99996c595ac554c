#pragma once

#include <cstdint>

#include "arbox/geometry/box.h"
#include "arbox/simulation/models.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// Puts a model at `center` as an object called "Car" that heads along x and stands still.
inline void place_car(Scene& scene, ModelKind kind, const Eigen::Vector3d& center) {
  const Model& shape = model(kind, 0);
  Instance instance;
  instance.mesh = shape.mesh;
  instance.pose.translate(center);
  instance.object = static_cast<std::int32_t>(scene.objects.size());
  scene.instances.push_back(instance);
  scene.objects.push_back({.label = "Car",
                           .box = geometry::make_yaw_box(center, shape.size, 0.0),
                           .velocity = Eigen::Vector3d::Zero()});
}

}  // namespace arbox::simulation
