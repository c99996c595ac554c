#pragma once

#include "arbox/training/scene.h"

/// \file
/// Changes to a whole scene: points, boxes and ground move together, so that a point that was
/// inside a box stays inside (up to float32 rounding of the points). Intensities and the order of
/// points stay. Boxes stand upright.

namespace arbox::training {

/// Mirrors left and right: y becomes -y, headings change their sign.
void flip_left_right(Scene& scene);

/// Mirrors front and back: x becomes -x, a heading becomes pi minus itself.
void flip_front_back(Scene& scene);

/// Turns everything about +z by `angle` radians, counter-clockwise.
void rotate(Scene& scene, double angle);

/// Multiplies places and sizes. Throws InvalidArgument unless the factor is finite and above zero.
void scale(Scene& scene, double factor);

/// Height (z) of the ground under or over (x, y). Throws InvalidArgument for a plane that stands
/// upright.
double ground_height(const io::KittiPlane& ground, double x, double y);

}  // namespace arbox::training
