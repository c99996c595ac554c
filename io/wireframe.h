#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "arbox/geometry/detection.h"

/// \file
/// Boxes as a picture that mesh viewers open.

namespace arbox::io {

using RgbBytes = std::array<std::uint8_t, 3>;

/// The detections' boxes as an ASCII PLY mesh: every edge, and a heading mark from the centre out
/// through the front (+x) face, is a thin bar of 12 triangles, coloured by class. A mesh, since
/// CloudCompare and MeshLab show no lines of a PLY file. Bars are `thickness` times the box's
/// diagonal wide. Coordinates are doubles in the frame of the boxes, metres, six decimals.
///
/// No detections give a mesh without vertices. Throws InvalidArgument for invalid boxes.
std::string format_wireframes_ply(std::span<const geometry::Detection> detections,
                                  const std::function<RgbBytes(std::string_view)>& color_of_class,
                                  double thickness = 0.01);

}  // namespace arbox::io
