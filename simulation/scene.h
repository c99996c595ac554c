#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/simulation/mesh.h"

namespace arbox::simulation {

/// A labelled thing. Its box stands where the object is at the reference time (the moment when the
/// scanner looks forward), in the LiDAR frame of that time.
struct SceneObject {
  /// KITTI's names: Car, Van, Truck, Pedestrian, Person_sitting, Cyclist, Tram, Misc.
  std::string label;
  geometry::Box box;
  /// Metres a second over the ground, in the LiDAR frame of the reference time.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// A mesh placed in the scene. Meshes are shared: a prototype is built once.
struct Instance {
  std::shared_ptr<const TriangleMesh> mesh;
  /// Mesh frame to the LiDAR frame of the reference time; may stretch the mesh along its axes.
  Eigen::Affine3d pose = Eigen::Affine3d::Identity();
  /// Index into Scene::objects; -1 for the rest of the world.
  std::int32_t object = -1;
  /// Multiplies the reflectivity of this instance's paint, cloth, walls and plants.
  double brightness = 1.0;
};

/// The own vehicle's movement, constant during a revolution.
struct EgoMotion {
  /// Metres a second, along +x.
  double speed = 0.0;
  /// Radians a second about +z.
  double yaw_rate = 0.0;
};

/// Paint on the road, which cameras see: strokes along a course that bends by `curvature` (1 / m,
/// positive to the left) from the origin, at offsets to the left of it.
struct RoadMarkings {
  struct Line {
    double offset = 0.0;  ///< Metres to the left.
    bool dashed = false;
  };
  /// A stretch of the course, metres, without lines on one side.
  struct Gap {
    double from = 0.0, to = 0.0;
    bool left = true;
  };
  double curvature = 0.0;
  std::vector<Line> lines;
  std::vector<Gap> gaps;
};

/// Everything that a sensor needs. The LiDAR frame of the reference time: x forward, y left, z up,
/// origin in the scanner.
struct Scene {
  std::vector<SceneObject> objects;
  std::vector<Instance> instances;
  EgoMotion ego;
  /// Ground plane under the own vehicle: normal . p + offset = 0, for the planes files.
  Eigen::Vector3d ground_normal = Eigen::Vector3d::UnitZ();
  double ground_offset = 1.73;
  RoadMarkings markings;
  std::uint64_t seed = 0;
};

}  // namespace arbox::simulation
