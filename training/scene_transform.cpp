#include "arbox/training/scene_transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "arbox/base/error.h"

namespace arbox::training {
namespace {

using geometry::Box;
using geometry::PointCloud;

constexpr double kPi = std::numbers::pi;

/// Calls change(x, y, z) for every point.
template <class Change>
void change_points(PointCloud& cloud, const Change& change) {
  const std::size_t columns = cloud.columns();
  for (std::size_t i = 0; i + columns <= cloud.values.size(); i += columns) {
    change(cloud.values[i], cloud.values[i + 1], cloud.values[i + 2]);
  }
}

void set_heading(Box& box, double heading) {
  box.rotation = geometry::make_yaw_box(box.center, box.size, heading).rotation;
}

}  // namespace

void flip_left_right(Scene& scene) {
  change_points(scene.cloud, [](float&, float& y, float&) { y = -y; });
  for (SceneObject& object : scene.objects) {
    const double heading = geometry::yaw(object.box);
    object.box.center.y() *= -1;
    set_heading(object.box, -heading);
  }
  if (scene.ground) scene.ground->normal.y() *= -1;
}

void flip_front_back(Scene& scene) {
  change_points(scene.cloud, [](float& x, float&, float&) { x = -x; });
  for (SceneObject& object : scene.objects) {
    const double heading = geometry::yaw(object.box);
    object.box.center.x() *= -1;
    set_heading(object.box, kPi - heading);
  }
  if (scene.ground) scene.ground->normal.x() *= -1;
}

void rotate(Scene& scene, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  change_points(scene.cloud, [&](float& x, float& y, float&) {
    const double turned = c * x - s * y;
    y = static_cast<float>(s * x + c * y);
    x = static_cast<float>(turned);
  });
  const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitZ());
  for (SceneObject& object : scene.objects) {
    const double heading = geometry::yaw(object.box);
    object.box.center = turn * object.box.center;
    set_heading(object.box, heading + angle);
  }
  if (scene.ground) scene.ground->normal = turn * scene.ground->normal;
}

void scale(Scene& scene, double factor) {
  if (!std::isfinite(factor) || factor <= 0) {
    throw InvalidArgument("scale: expected a factor above zero, got " + std::to_string(factor));
  }
  change_points(scene.cloud, [&](float& x, float& y, float& z) {
    x = static_cast<float>(factor * x);
    y = static_cast<float>(factor * y);
    z = static_cast<float>(factor * z);
  });
  for (SceneObject& object : scene.objects) {
    object.box.center *= factor;
    object.box.size *= factor;
  }
  if (scene.ground) scene.ground->offset *= factor;
}

double ground_height(const io::KittiPlane& ground, double x, double y) {
  if (std::abs(ground.normal.z()) < 1e-3) {
    throw InvalidArgument("ground_height: expected a plane that lies, got one that stands upright");
  }
  return -(ground.normal.x() * x + ground.normal.y() * y + ground.offset) / ground.normal.z();
}

}  // namespace arbox::training
