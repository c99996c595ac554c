#include "arbox/simulation/internal/look.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "arbox/base/random.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kLook = 401;

template <std::size_t N>
const Rgb& one_of(const std::array<Rgb, N>& colors, const RandomStream& random,
                  std::uint32_t draw) {
  return colors[random.below(draw, static_cast<std::uint32_t>(N))];
}

struct Palettes {
  std::array<Rgb, 9> clothes = {
      from_srgb(40, 48, 78),    from_srgb(150, 36, 40),  from_srgb(44, 44, 46),
      from_srgb(200, 196, 188), from_srgb(64, 96, 72),   from_srgb(66, 112, 160),
      from_srgb(196, 148, 52),  from_srgb(120, 74, 110), from_srgb(112, 110, 108)};
  std::array<Rgb, 4> trousers = {from_srgb(38, 48, 78), from_srgb(34, 34, 36),
                                 from_srgb(110, 98, 80), from_srgb(80, 84, 92)};
  std::array<Rgb, 4> hair = {from_srgb(36, 26, 20), from_srgb(84, 56, 34), from_srgb(150, 116, 70),
                             from_srgb(120, 116, 112)};
  std::array<Rgb, 3> skin = {from_srgb(216, 168, 140), from_srgb(190, 138, 108),
                             from_srgb(118, 78, 56)};
  std::array<Rgb, 6> walls = {from_srgb(222, 212, 190), from_srgb(206, 190, 160),
                              from_srgb(226, 222, 214), from_srgb(214, 186, 150),
                              from_srgb(196, 200, 196), from_srgb(220, 200, 176)};
  std::array<Rgb, 4> roofs = {from_srgb(140, 74, 56), from_srgb(122, 64, 52), from_srgb(98, 82, 76),
                              from_srgb(150, 90, 66)};
  std::array<Rgb, 5> plants = {from_srgb(70, 104, 42), from_srgb(84, 116, 50),
                               from_srgb(58, 92, 46), from_srgb(98, 118, 54),
                               from_srgb(64, 96, 62)};
  std::array<Rgb, 3> trams = {from_srgb(196, 150, 30), from_srgb(170, 36, 34),
                              from_srgb(40, 80, 150)};
  std::array<Rgb, 6> hues = {from_srgb(150, 24, 28),  from_srgb(30, 62, 140),
                             from_srgb(36, 88, 128),  from_srgb(38, 84, 60),
                             from_srgb(176, 150, 96), from_srgb(196, 92, 30)};
};

const Palettes& palettes() {
  static const Palettes known;
  return known;
}

/// Most cars are grey; how light follows from what the laser sees.
Rgb draw_paint(const RandomStream& random, double brightness) {
  const double lightness = std::clamp(0.02 + 0.55 * std::pow(brightness, 1.3), 0.02, 0.78);
  if (random.uniform(0) < 0.62) return Rgb(0.97f, 0.99f, 1.0f) * static_cast<float>(lightness);
  return scaled(one_of(palettes().hues, random, 1), 0.45 + 1.1 * lightness);
}

}  // namespace

Rgb scaled(const Rgb& color, double factor) {
  return (static_cast<float>(factor) * color).min(0.85f);
}

Look draw_look(const Scene& scene, std::size_t instance) {
  const Instance& placed = scene.instances[instance];
  const Palettes& known = palettes();
  const RandomStream random(scene.seed, instance, kLook);
  const double shade = std::clamp(placed.brightness, 0.6, 1.4);
  Look look;
  look.paint = draw_paint(random, placed.brightness);
  look.cover = scaled(one_of(known.clothes, random, 2), 1.1);
  look.top = scaled(one_of(known.clothes, random, 3), shade);
  look.trousers = one_of(known.trousers, random, 4);
  look.hair = one_of(known.hair, random, 5);
  look.skin = one_of(known.skin, random, 6);
  look.wall = scaled(one_of(known.walls, random, 7), shade);
  look.roof = scaled(one_of(known.roofs, random, 8), shade);
  look.plant =
      scaled(one_of(known.plants, random, 9), 1.25 * shade * random.uniform(10, 0.85, 1.15));
  look.wood = scaled(from_srgb(134, 98, 66), shade * random.uniform(11, 0.7, 1.4));
  if (placed.object < 0) return look;
  const std::string& label = scene.objects[static_cast<std::size_t>(placed.object)].label;
  const bool person = label == "Pedestrian" || label == "Cyclist" || label == "Person_sitting";
  look.role = person            ? Look::Role::kPerson
              : label == "Tram" ? Look::Role::kTram
                                : Look::Role::kVehicle;
  if (look.role == Look::Role::kTram) look.paint = one_of(known.trams, random, 12);
  if (label == "Car" || label == "Van") look.cover = from_srgb(52, 52, 55);
  return look;
}

}  // namespace arbox::simulation
