#include "arbox/simulation/internal/surface_colors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "arbox/base/random.h"
#include "arbox/simulation/internal/road_paint.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kLook = 401;
/// Where hair grows on bare heads, as heights in a person's box.
constexpr double kCrown = 0.462, kNape = 0.40;

Rgb scaled(const Rgb& color, double factor) {
  return (static_cast<float>(factor) * color).min(0.85f);
}

template <std::size_t N>
const Rgb& one_of(const std::array<Rgb, N>& colors, const RandomStream& random,
                  std::uint32_t draw) {
  return colors[random.below(draw, static_cast<std::uint32_t>(N))];
}

/// Most cars are grey; how light follows from what the laser sees.
Rgb draw_paint(const RandomStream& random, double brightness) {
  static const std::array<Rgb, 6> hues = {from_srgb(150, 24, 28),  from_srgb(30, 62, 140),
                                          from_srgb(36, 88, 128),  from_srgb(38, 84, 60),
                                          from_srgb(176, 150, 96), from_srgb(196, 92, 30)};
  const double lightness = std::clamp(0.02 + 0.55 * std::pow(brightness, 1.3), 0.02, 0.78);
  if (random.uniform(0) < 0.62) return Rgb(0.97f, 0.99f, 1.0f) * static_cast<float>(lightness);
  return scaled(one_of(hues, random, 1), 0.45 + 1.1 * lightness);
}

}  // namespace

SurfaceColors::SurfaceColors(const Scene& scene) : scene_(scene) {
  looks_.reserve(scene.instances.size());
  for (std::size_t i = 0; i < scene.instances.size(); ++i) looks_.push_back(draw_look(scene, i));
}

SurfaceColors::Look SurfaceColors::draw_look(const Scene& scene, std::size_t instance) {
  static const std::array<Rgb, 9> clothes = {
      from_srgb(40, 48, 78),    from_srgb(150, 36, 40),  from_srgb(44, 44, 46),
      from_srgb(200, 196, 188), from_srgb(64, 96, 72),   from_srgb(66, 112, 160),
      from_srgb(196, 148, 52),  from_srgb(120, 74, 110), from_srgb(112, 110, 108)};
  static const std::array<Rgb, 4> trousers = {from_srgb(38, 48, 78), from_srgb(34, 34, 36),
                                              from_srgb(110, 98, 80), from_srgb(80, 84, 92)};
  static const std::array<Rgb, 4> hair = {from_srgb(36, 26, 20), from_srgb(84, 56, 34),
                                          from_srgb(150, 116, 70), from_srgb(120, 116, 112)};
  static const std::array<Rgb, 3> skin = {from_srgb(216, 168, 140), from_srgb(190, 138, 108),
                                          from_srgb(118, 78, 56)};
  static const std::array<Rgb, 6> walls = {from_srgb(222, 212, 190), from_srgb(206, 190, 160),
                                           from_srgb(226, 222, 214), from_srgb(214, 186, 150),
                                           from_srgb(196, 200, 196), from_srgb(220, 200, 176)};
  static const std::array<Rgb, 4> roofs = {from_srgb(140, 74, 56), from_srgb(122, 64, 52),
                                           from_srgb(98, 82, 76), from_srgb(150, 90, 66)};
  static const std::array<Rgb, 5> plants = {from_srgb(70, 104, 42), from_srgb(84, 116, 50),
                                            from_srgb(58, 92, 46), from_srgb(98, 118, 54),
                                            from_srgb(64, 96, 62)};
  static const std::array<Rgb, 3> trams = {from_srgb(196, 150, 30), from_srgb(170, 36, 34),
                                           from_srgb(40, 80, 150)};
  const Instance& placed = scene.instances[instance];
  const RandomStream random(scene.seed, instance, kLook);
  const double shade = std::clamp(placed.brightness, 0.6, 1.4);
  Look look;
  look.paint = draw_paint(random, placed.brightness);
  look.cover = scaled(one_of(clothes, random, 2), 1.1);
  look.top = scaled(one_of(clothes, random, 3), shade);
  look.trousers = one_of(trousers, random, 4);
  look.hair = one_of(hair, random, 5);
  look.skin = one_of(skin, random, 6);
  look.wall = scaled(one_of(walls, random, 7), shade);
  look.roof = scaled(one_of(roofs, random, 8), shade);
  look.plant = scaled(one_of(plants, random, 9), 1.25 * shade * random.uniform(10, 0.85, 1.15));
  look.wood = scaled(from_srgb(134, 98, 66), shade * random.uniform(11, 0.7, 1.4));
  if (placed.object < 0) return look;
  const std::string& label = scene.objects[static_cast<std::size_t>(placed.object)].label;
  const bool person = label == "Pedestrian" || label == "Cyclist" || label == "Person_sitting";
  look.role = person            ? Look::Role::kPerson
              : label == "Tram" ? Look::Role::kTram
                                : Look::Role::kVehicle;
  if (look.role == Look::Role::kTram) look.paint = one_of(trams, random, 12);
  if (label == "Car" || label == "Van") look.cover = from_srgb(52, 52, 55);
  return look;
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
