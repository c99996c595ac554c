#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace arbox::simulation {

/// Linear light: red, green, blue.
using Rgb = Eigen::Array3f;

/// The linear light of an sRGB colour, 0..255 each.
Rgb from_srgb(int red, int green, int blue);

/// Sun and sky of a scene.
struct Daylight {
  Eigen::Vector3d sun = Eigen::Vector3d::UnitZ();  ///< Unit vector towards the sun.
  Rgb sun_light, zenith, horizon, bounce;

  /// The sky, or the haze over far land, in a unit direction.
  Rgb sky(const Eigen::Vector3d& direction) const;
  /// What falls on a surface from the whole sky and from the ground.
  Rgb ambient(const Eigen::Vector3d& normal) const;
};

/// Height, direction and clouds drawn for the scene.
Daylight draw_daylight(std::uint64_t seed);

/// What reaches the camera of a surface that shines with `light` behind `distance` metres of air.
Rgb through_haze(const Daylight& day, const Rgb& light, double distance);

/// Light to 8-bit sRGB, bright light compressed.
Eigen::Array<std::uint8_t, 3, 1> exposed(const Rgb& light);

}  // namespace arbox::simulation
