#pragma once

#include <cstdint>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/simulation/lidar_model.h"
#include "arbox/simulation/ray_tracer.h"

namespace arbox::simulation {

/// One return.
struct LidarReturn {
  float x = 0, y = 0, z = 0;  ///< Metres, in the scanner's frame when the pulse left.
  float intensity = 0;        ///< 0..1.
  std::uint16_t ring = 0;
  std::uint16_t firing = 0;  ///< Counts from the start of the revolution.
  float time = 0;            ///< Seconds from the start of the revolution.
  std::int32_t object = -1;  ///< Index into Scene::objects, or -1.
  Material material = Material::kAsphalt;
};

struct LidarOptions {
  /// Moves every return into the frame of the reference time, as if the own vehicle stood still.
  /// KITTI's object scans are not compensated.
  bool motion_compensated = false;
  /// No noise, no drop-outs, no rounding: for tests and for exact geometry.
  bool ideal = false;
};

/// A revolution of the scanner in the scene: ring by ring from the top, each counter-clockwise from
/// azimuth 0. Random numbers depend on (scene.seed, ring, firing) alone.
std::vector<LidarReturn> scan(const Scene& scene, const RayTracer& tracer, const LidarModel& model,
                              const LidarOptions& options = {});

/// Where such a scan shows each object of the scene: its box in the frame of its returns, at the
/// moment when the scanner faces the middle of the box. Without compensation the own vehicle's
/// movement and the object's shift the box, up to half a revolution's way behind the scanner; with
/// it only the object's do. KITTI's annotators drew boxes around returns, so labels say these. The
/// beams' own azimuth offsets (a few degrees) are left out.
std::vector<geometry::Box> scanned_boxes(const Scene& scene, const LidarModel& model,
                                         const LidarOptions& options = {});

/// x y z intensity rows, as velodyne files have them.
geometry::PointCloud to_cloud(const std::vector<LidarReturn>& returns);

}  // namespace arbox::simulation
