#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// Where a ray meets the scene.
struct Hit {
  double distance = 0.0;
  /// Unit normal, turned against the ray.
  Eigen::Vector3d normal;
  Material material = Material::kAsphalt;
  double brightness = 1.0;
  /// Index into Scene::objects, or -1.
  std::int32_t object = -1;
  std::int32_t instance = -1;
};

/// Rays against a scene (Embree). Objects with a velocity move during the revolution.
///
/// Building is single-threaded, so that the same scene gives the same hits on every run; build
/// scenes side by side to use the cores. Tracing is const and may be done from several threads. The
/// scene must outlive the tracer.
class RayTracer {
 public:
  /// `duration` is the time of one revolution, seconds; time 0.5 is the reference time.
  RayTracer(const Scene& scene, double duration);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  /// The nearest surface between `nearest` and `farthest` metres along the unit direction, at
  /// `time` in [0, 1] of the revolution. False if there is none.
  bool trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
             double nearest, double farthest, Hit& hit) const;

  /// True if anything lies there; cheaper than to ask what.
  bool blocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
               double nearest, double farthest) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arbox::simulation
