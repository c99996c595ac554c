#include "arbox/simulation/internal/daylight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/base/random.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kWeather = 400;
constexpr double kHazeDistance = 900.0;
constexpr float kExposure = 1.7f;

float to_linear(int value) {
  const float v = static_cast<float>(value) / 255.0f;
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

Rgb mixed(const Rgb& a, const Rgb& b, double share) {
  return a + static_cast<float>(share) * (b - a);
}

}  // namespace

Rgb from_srgb(int red, int green, int blue) {
  return {to_linear(red), to_linear(green), to_linear(blue)};
}

Daylight draw_daylight(std::uint64_t seed) {
  const RandomStream random(seed, 0, kWeather);
  const double degree = std::numbers::pi / 180.0;
  const double height = random.uniform(0, 28, 62) * degree;
  const double azimuth = random.uniform(1, 0, 360) * degree;
  const double clouds = std::pow(random.uniform(2), 2.0);
  Daylight day;
  day.sun = {std::cos(height) * std::cos(azimuth), std::cos(height) * std::sin(azimuth),
             std::sin(height)};
  day.sun_light = static_cast<float>(1.0 - 0.8 * clouds) * Rgb(1.05f, 0.95f, 0.80f);
  day.zenith = mixed(Rgb(0.13f, 0.29f, 0.62f), Rgb(0.52f, 0.57f, 0.64f), clouds);
  day.horizon = mixed(Rgb(0.60f, 0.72f, 0.86f), Rgb(0.78f, 0.80f, 0.83f), clouds);
  day.bounce = 0.10f * day.sun_light + Rgb::Constant(0.07f);
  return day;
}

Rgb Daylight::sky(const Eigen::Vector3d& direction) const {
  const double up = std::max(0.0, direction.z());
  const Rgb clear = mixed(horizon, zenith, 1.0 - std::pow(1.0 - up, 4.0));
  const double glow = std::pow(std::max(0.0, direction.dot(sun)), 24.0);
  return clear + static_cast<float>(0.35 * glow) * sun_light;
}

Rgb Daylight::ambient(const Eigen::Vector3d& normal) const {
  const Rgb above = 0.55f * (0.5f * zenith + 0.5f * horizon) + Rgb::Constant(0.10f);
  return mixed(bounce, above, 0.5 + 0.5 * normal.z());
}

Rgb through_haze(const Daylight& day, const Rgb& light, double distance) {
  return mixed(light, day.horizon, 1.0 - std::exp(-distance / kHazeDistance));
}

Eigen::Array<std::uint8_t, 3, 1> exposed(const Rgb& light) {
  const auto encode = [](float value) {
    const float v = 1.0f - std::exp(-kExposure * std::max(0.0f, value));
    const float s = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(s, 0.0f, 1.0f)));
  };
  return {encode(light[0]), encode(light[1]), encode(light[2])};
}

}  // namespace arbox::simulation
