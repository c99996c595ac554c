#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/kitti_calibration.h"

namespace arbox::training {

/// Label of things that a network does not look for. They take room, and they may be taken for
/// something that it does look for.
inline constexpr int kOtherObject = -1;

/// A labelled object.
struct SceneObject {
  geometry::Box box;
  /// Index into the class names of the network, or kOtherObject.
  int label = 0;
  /// Of other objects: the class that they are easily taken for (a van for a car), or -1.
  int resembles = -1;
  /// 0 easy, 1 moderate, 2 hard, -1 harder than hard, as the KITTI benchmark has them; where an
  /// object was not seen by a camera, by its points (training/scene_objects.h).
  int difficulty = 0;
};

namespace pv_rcnn {
struct KeptRegions;
}

/// A scan with its objects. LiDAR frame, metres.
struct Scene {
  /// Columns x, y, z, intensity in 0..1.
  geometry::PointCloud cloud;
  std::vector<SceneObject> objects;
  /// The road in the LiDAR frame, where objects may be placed; absent if not known.
  std::optional<io::KittiPlane> ground;
  /// File or seed that the scene is from, for messages.
  std::string source;
  /// What frozen stages made of it once (pv_rcnn/kept_regions.h), in place of points and objects.
  std::shared_ptr<const pv_rcnn::KeptRegions> regions;
  /// Where to keep that, if it is to be kept.
  std::filesystem::path regions_file;
};

/// Scenes by number. Thread-safe, and a scene depends on its number alone, so that runs can be
/// repeated and resumed.
class SceneSource {
 public:
  virtual ~SceneSource() = default;
  /// Scenes of an epoch.
  virtual std::int64_t size() const = 0;
  /// Scene number `index`, 0 to size() - 1. Throws IoError and FormatError, naming the file.
  virtual Scene scene(std::int64_t index) const = 0;
};

}  // namespace arbox::training
