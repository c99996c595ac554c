#include "arbox/simulation/internal/surface_colors.h"

#include <cmath>

#include "arbox/simulation/internal/road_paint.h"

namespace arbox::simulation {
namespace {

/// Where hair grows on bare heads, as heights in a person's box.
constexpr double kCrown = 0.462, kNape = 0.40;

}  // namespace

SurfaceColors::SurfaceColors(const Scene& scene) : scene_(scene) {
  looks_.reserve(scene.instances.size());
  for (std::size_t i = 0; i < scene.instances.size(); ++i) looks_.push_back(draw_look(scene, i));
}

Rgb SurfaceColors::color(const Hit& hit, const Eigen::Vector3d& point) const {
  const Look& look = looks_[static_cast<std::size_t>(hit.instance)];
  if (hit.object < 0) return thing(look, hit, point);
  const geometry::Box& box = scene_.objects[static_cast<std::size_t>(hit.object)].box;
  const Eigen::Vector3d place =
      (box.rotation.conjugate() * (point - box.center)).cwiseQuotient(box.size);
  return look.role == Look::Role::kPerson ? person(look, hit, place) : vehicle(look, hit, place);
}

Rgb SurfaceColors::person(const Look& look, const Hit& hit, const Eigen::Vector3d& place) const {
  const SceneObject& object = scene_.objects[static_cast<std::size_t>(hit.object)];
  const std::string& label = object.label;
  const double facing = (object.box.rotation.conjugate() * hit.normal).x();
  switch (hit.material) {
    case Material::kSkin:
      return place.z() > kCrown || (place.z() > kNape && facing < -0.1) ? look.hair : look.skin;
    case Material::kCloth: {
      const double belt = label == "Cyclist" ? 0.12 : label == "Pedestrian" ? 0.02 : -0.05;
      if (place.z() > (label == "Person_sitting" ? 0.40 : 0.42)) return look.hair;
      return place.z() < belt ? look.trousers : look.top;
    }
    case Material::kPaintLight:
      return look.paint;
    case Material::kMetal:
      return from_srgb(120, 122, 124);
    case Material::kWood:
      return look.wood;
    case Material::kRetroreflector:
      return from_srgb(190, 30, 30);
    default:
      return from_srgb(34, 32, 32);
  }
}

Rgb SurfaceColors::vehicle(const Look& look, const Hit& hit, const Eigen::Vector3d& place) const {
  switch (hit.material) {
    case Material::kPaintLight:
    case Material::kPaintDark:
      if (look.role == Look::Role::kTram && place.z() > 0.30) return from_srgb(214, 212, 206);
      return look.paint;
    case Material::kCloth:
      return look.cover;
    case Material::kMetal:
      return place.x() > 0.4 ? from_srgb(222, 224, 226) : from_srgb(158, 160, 164);
    case Material::kRetroreflector:
      return place.x() > 0.0 || std::abs(place.y()) < 0.2 ? from_srgb(226, 226, 220)
                                                          : from_srgb(176, 20, 22);
    case Material::kWood:
      return look.wood;
    case Material::kSkin:
      return look.skin;
    case Material::kRubber:
      return from_srgb(30, 30, 31);
    default:
      return from_srgb(48, 48, 51);
  }
}

Rgb SurfaceColors::thing(const Look& look, const Hit& hit, const Eigen::Vector3d& point) const {
  switch (hit.material) {
    case Material::kAsphalt:
    case Material::kConcrete:
    case Material::kGrass:
    case Material::kGravel:
      return ground(hit, point);
    case Material::kBrick:
      return look.roof;
    case Material::kPlaster:
      return look.wall;
    case Material::kWood:
      return look.wood;
    case Material::kBark:
      return scaled(from_srgb(92, 76, 62), hit.brightness);
    case Material::kFoliage:
      return look.plant;
    case Material::kMetal:
      return scaled(from_srgb(142, 146, 148), hit.brightness);
    case Material::kPaintLight:
    case Material::kPaintDark:
      return look.paint;
    case Material::kCloth:
      return from_srgb(206, 200, 190);
    case Material::kRetroreflector:
      return sign(hit, point);
    default:
      return scaled(from_srgb(62, 66, 66), hit.brightness);
  }
}

Rgb SurfaceColors::ground(const Hit& hit, const Eigen::Vector3d& point) const {
  const double fine = patchiness(point, 0.35), wide = patchiness(point, 3.0);
  switch (hit.material) {
    case Material::kAsphalt:
      if (is_painted(scene_.markings, point)) return from_srgb(216, 216, 212);
      return scaled(from_srgb(98, 97, 94), 1.0 + 0.07 * fine + 0.08 * wide);
    case Material::kConcrete:
      return scaled(from_srgb(158, 153, 146), 1.0 + 0.06 * fine + 0.06 * wide);
    case Material::kGravel:
      return scaled(from_srgb(150, 138, 120), 1.0 + 0.2 * fine);
    default:
      return scaled(from_srgb(96, 116, 58), 1.0 + 0.16 * fine + 0.2 * wide);
  }
}

/// Round and three-cornered signs have a red rim, square ones are blue.
Rgb SurfaceColors::sign(const Hit& hit, const Eigen::Vector3d& point) const {
  const Instance& placed = scene_.instances[static_cast<std::size_t>(hit.instance)];
  const Eigen::AlignedBox3d bounds = placed.mesh->bounds().cast<double>();
  const Eigen::Vector3d local = placed.pose.inverse() * point;
  if (bounds.sizes().y() < 0.55) return from_srgb(34, 76, 160);
  const double rim = bounds.sizes().y() > 0.6 ? 0.25 : 0.13;
  const double radius = std::hypot(local.y(), local.z() - (bounds.max().z() - 0.33));
  return radius > rim ? from_srgb(186, 28, 32) : from_srgb(228, 228, 224);
}

}  // namespace arbox::simulation
