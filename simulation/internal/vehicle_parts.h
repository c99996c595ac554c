#pragma once

#include <span>

#include "arbox/simulation/internal/mesh_builder.h"

/// \file
/// What the bodies of cars, trucks and trams are made of. Metres; x points to the vehicle's front,
/// y to its left, z up from the ground.

namespace arbox::simulation {

/// A cross section of a body at x: heights of its floor, shoulder and roof's edge, half its widths
/// at the two latter; and what covers it as far as the next one.
struct Station {
  float x, bottom, shoulder, top;
  float half_shoulder, half_top;
  Material side = Material::kPaintLight;
  Material roof = Material::kPaintLight;
};

/// The skin between each of at least two stations and the next, the same on both sides, closed at
/// both ends.
void loft(MeshBuilder& body, std::span<const Station> stations);

/// A seat, or a bench from a width of 0.8 m, with its back at `x` and its middle at `y`; `cushion`
/// and `top` are heights.
void add_seat(MeshBuilder& body, float x, float y, float width, float cushion, float top);

/// A wheel whose axle is along y, with its outer face at `outer`.
void add_wheel(MeshBuilder& body, float x, float outer, float inner, float radius);

}  // namespace arbox::simulation
