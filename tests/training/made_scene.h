#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/training/scene.h"

namespace arbox::training {

/// A scene of two cars, a pedestrian and a van, each with points inside of its box and scattered
/// points between -40 and 40 m that are in none.
inline Scene made_scene(std::uint64_t seed, int points_per_object = 60, int scattered = 2000) {
  const RandomStream random(seed, 0, 7);
  std::uint32_t draw = 0;
  const auto u = [&](double low, double high) { return random.uniform(draw++, low, high); };
  Scene scene;
  scene.cloud.channels = {"intensity"};
  scene.source = "made scene";
  scene.ground =
      io::KittiPlane{.normal = Eigen::Vector3d(0.02, -0.01, 1).normalized(), .offset = 1.7};
  const auto add = [&](int label, int resembles, const Eigen::Vector3d& size, double x, double y) {
    SceneObject object;
    object.box = geometry::make_yaw_box({x + u(-1, 1), y + u(-1, 1), -1.7 + 0.5 * size.z()}, size,
                                        u(-3.1, 3.1));
    object.label = label;
    object.resembles = resembles;
    for (int i = 0; i < points_per_object; ++i) {
      const Eigen::Vector3d local(u(-0.49, 0.49), u(-0.49, 0.49), u(-0.49, 0.49));
      const Eigen::Vector3d point =
          object.box.center + object.box.rotation * local.cwiseProduct(size);
      for (int axis = 0; axis < 3; ++axis) {
        scene.cloud.values.push_back(static_cast<float>(point[axis]));
      }
      scene.cloud.values.push_back(static_cast<float>(u(0, 1)));
    }
    scene.objects.push_back(object);
  };
  add(0, -1, {3.9, 1.6, 1.5}, 12, 3);
  add(0, -1, {4.2, 1.7, 1.6}, 20, -8);
  add(1, -1, {0.8, 0.6, 1.7}, 8, -4);
  add(kOtherObject, 0, {5.0, 1.9, 2.2}, 25, 9);
  for (int i = 0; i < scattered; ++i) {
    const Eigen::Vector3d point(u(-40, 40), u(-40, 40), u(-2, 2));
    const double intensity = u(0, 1);
    bool inside = false;
    for (const SceneObject& object : scene.objects) {
      inside = inside || geometry::contains(object.box, point, 0.05);
    }
    if (inside) continue;
    for (int axis = 0; axis < 3; ++axis) {
      scene.cloud.values.push_back(static_cast<float>(point[axis]));
    }
    scene.cloud.values.push_back(static_cast<float>(intensity));
  }
  return scene;
}

/// Scenes that were made before.
class ListedScenes : public SceneSource {
 public:
  explicit ListedScenes(std::vector<Scene> scenes) : scenes_(std::move(scenes)) {}
  std::int64_t size() const override { return static_cast<std::int64_t>(scenes_.size()); }
  Scene scene(std::int64_t index) const override {
    return scenes_.at(static_cast<std::size_t>(index));
  }

 private:
  std::vector<Scene> scenes_;
};

}  // namespace arbox::training
