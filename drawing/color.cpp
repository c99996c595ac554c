#include "arbox/drawing/color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace arbox::drawing {
namespace {

struct Oklab {
  double l, a, b;
};

double to_linear(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

std::uint8_t from_linear(double v) {
  v = std::clamp(v, 0.0, 1.0);
  const double encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * encoded));
}

Oklab to_oklab(Color color) {
  const double r = to_linear(color.r), g = to_linear(color.g), b = to_linear(color.b);
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

Color to_color(const Oklab& lab) {
  const double l = std::pow(lab.l + 0.3963377774 * lab.a + 0.2158037573 * lab.b, 3);
  const double m = std::pow(lab.l - 0.1055613458 * lab.a - 0.0638541728 * lab.b, 3);
  const double s = std::pow(lab.l - 0.0894841775 * lab.a - 1.2914855480 * lab.b, 3);
  return {from_linear(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          from_linear(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          from_linear(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

Oklab interpolate(const Oklab& from, const Oklab& to, double t) {
  return {std::lerp(from.l, to.l, t), std::lerp(from.a, to.a, t), std::lerp(from.b, to.b, t)};
}

constexpr std::array<Color, 7> kPalette = {{{0, 114, 178},
                                            {213, 94, 0},
                                            {0, 158, 115},
                                            {204, 121, 167},
                                            {230, 159, 0},
                                            {86, 180, 233},
                                            {90, 90, 90}}};

constexpr std::array<std::pair<std::string_view, Color>, 29> kClassColors = {
    {{"Car", {213, 94, 0}},           {"Pedestrian", {196, 60, 140}},
     {"Cyclist", {0, 140, 95}},       {"Van", {230, 159, 0}},
     {"Truck", {150, 75, 20}},        {"Person_sitting", {204, 121, 167}},
     {"Tram", {170, 40, 40}},         {"Misc", {110, 110, 110}},
     {"bathtub", {0, 150, 170}},      {"bed", {0, 158, 115}},
     {"bookshelf", {150, 75, 20}},    {"cabinet", {86, 180, 233}},
     {"chair", {0, 114, 178}},        {"counter", {130, 140, 30}},
     {"curtain", {240, 140, 150}},    {"desk", {213, 94, 0}},
     {"door", {230, 159, 0}},         {"dresser", {204, 121, 167}},
     {"garbagebin", {90, 90, 90}},    {"lamp", {170, 40, 40}},
     {"night_stand", {110, 60, 170}}, {"picture", {110, 190, 60}},
     {"refrigerator", {70, 90, 210}}, {"showercurtrain", {120, 205, 185}},
     {"sink", {165, 120, 60}},        {"sofa", {170, 40, 90}},
     {"table", {160, 120, 255}},      {"toilet", {0, 95, 60}},
     {"window", {0, 160, 200}}}};

// Hue turns from sea green over blue to violet while the lightness moves linearly.
Oklab cool_map(double t, double first_lightness, double last_lightness) {
  const double chroma = 0.055 + 0.075 * std::sin(t * M_PI * 0.6);
  const double hue = std::lerp(195.0, 300.0, t) * M_PI / 180.0;
  return {std::lerp(first_lightness, last_lightness, t), chroma * std::cos(hue),
          chroma * std::sin(hue)};
}

}  // namespace

Color mix(Color from, Color to, double t) {
  if (!(t > 0.0)) return from;
  if (t >= 1.0) return to;
  return to_color(interpolate(to_oklab(from), to_oklab(to), t));
}

Color palette_color(int i) { return kPalette[static_cast<std::size_t>(i) % kPalette.size()]; }

Color class_color(std::string_view name) {
  for (const auto& [known, color] : kClassColors) {
    if (known == name) return color;
  }
  std::uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return kPalette[(hash >> 8) % kPalette.size()];
}

Color map_color(double t, bool dark_background) {
  t = t > 0.0 ? std::min(t, 1.0) : 0.0;
  return to_color(dark_background ? cool_map(1.0 - t, 0.92, 0.42) : cool_map(t, 0.80, 0.32));
}

}  // namespace arbox::drawing
