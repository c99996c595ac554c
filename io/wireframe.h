#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/detection.h"

/// \file
/// Boxes as a picture that mesh viewers open.

namespace arbox::io {

using RgbBytes = std::array<std::uint8_t, 3>;

/// Triangles over vertices, seen from outside counter-clockwise.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A box as 13 thin bars, its edges and a heading mark from the centre out through the front (+x)
/// face, each of 8 vertices and 12 triangles. Bars are `thickness` times the box's diagonal wide.
/// Throws InvalidArgument for an invalid box and a thickness outside of (0, 1).
TriangleMesh wireframe_mesh(const geometry::Box& box, double thickness = 0.01);

/// The detections' boxes as an ASCII PLY mesh: each a wireframe_mesh, coloured by class. A mesh,
/// since CloudCompare and MeshLab show no lines of a PLY file. Coordinates are doubles in the frame
/// of the boxes, metres, six decimals.
///
/// No detections give a mesh without vertices. Throws as wireframe_mesh.
std::string format_wireframes_ply(std::span<const geometry::Detection> detections,
                                  const std::function<RgbBytes(std::string_view)>& color_of_class,
                                  double thickness = 0.01);

}  // namespace arbox::io
