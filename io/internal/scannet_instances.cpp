#include "arbox/io/internal/scannet_instances.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "arbox/io/scannet.h"

namespace arbox::io::internal {
namespace {

// Points of an instance may lie outside of its box by float32 rounding.
constexpr double kOutside = 1e-3;

}  // namespace

std::vector<std::int32_t> objects_of_instances(const LabeledScene& scene,
                                               std::span<const std::int32_t> instances,
                                               std::span<const std::int32_t> nyu40) {
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::AlignedBox3d> hulls;
  const auto view = scene.cloud.view();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (instances[i] > 0) hulls[{instances[i], nyu40[i]}].extend(view.position(i).cast<double>());
  }
  std::map<std::int32_t, std::int32_t> object_of;
  for (const auto& [key, hull] : hulls) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
      const LabeledObject& object = scene.objects[o];
      if (object.label != nyu40_name(key.second)) continue;
      const Eigen::Vector3d half = 0.5 * object.box.size;
      const Eigen::AlignedBox3d box(object.box.center - half, object.box.center + half);
      const double slack =
          std::max((box.min() - hull.min()).maxCoeff(), (hull.max() - box.max()).maxCoeff());
      const double distance = (hull.min() - box.min()).norm() + (box.max() - hull.max()).norm();
      if (slack > kOutside || distance >= best) continue;
      best = distance;
      object_of[key.first] = static_cast<std::int32_t>(o);
    }
  }
  std::vector<std::int32_t> objects;
  objects.reserve(instances.size());
  for (const std::int32_t instance : instances) {
    const auto found = object_of.find(instance);
    objects.push_back(found == object_of.end() ? -1 : found->second);
  }
  return objects;
}

std::vector<std::int32_t> objects_of_points(const LabeledScene& scene) {
  if (!scene.point_objects.empty()) return scene.point_objects;
  std::vector<geometry::Box> boxes;
  for (const LabeledObject& object : scene.objects) boxes.push_back(object.box);
  const auto inside = points_in_boxes(scene.cloud.view(), boxes, kOutside);
  std::vector<std::int32_t> objects(scene.cloud.size(), -1);
  for (std::size_t o = 0; o < inside.size(); ++o) {
    for (const std::int32_t point : inside[o]) objects[point] = static_cast<std::int32_t>(o);
  }
  return objects;
}

ScanNetPointLabels scannet_point_labels(const LabeledScene& scene) {
  std::vector<int> ids;
  for (const LabeledObject& object : scene.objects) ids.push_back(nyu40_id(object.label));
  ScanNetPointLabels labels;
  for (const std::int32_t object : objects_of_points(scene)) {
    labels.instances.push_back(object + 1);
    labels.nyu40.push_back(object < 0 ? 0 : ids[static_cast<std::size_t>(object)]);
  }
  return labels;
}

}  // namespace arbox::io::internal
