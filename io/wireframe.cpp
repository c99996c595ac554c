#include "arbox/io/wireframe.h"

#include "arbox/base/error.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using geometry::Box;

constexpr int kBarsOfABox = 13;
constexpr int kCornersOfABar = 8;
constexpr int kTrianglesOfABar = 12;
/// The heading mark reaches this share of the length beyond the front face.
constexpr double kHeadingReach = 0.25;

// Corners in the order of geometry::corners, seen from outside counter-clockwise.
constexpr std::uint32_t kTriangles[kTrianglesOfABar][3] = {
    {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};

Box bar(const Box& box, const Eigen::Vector3d& local_center, int axis, double length,
        double width) {
  Box result{.center = box.center + box.rotation * local_center,
             .size = Eigen::Vector3d::Constant(width),
             .rotation = box.rotation};
  result.size[axis] = length + width;
  return result;
}

std::array<Box, kBarsOfABox> bars(const Box& box, double thickness) {
  const double width = thickness * box.size.norm();
  std::array<Box, kBarsOfABox> result;
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int second = (axis + 1) % 3;
    const int third = (axis + 2) % 3;
    for (const double side : {-0.5, 0.5}) {
      for (const double other : {-0.5, 0.5}) {
        Eigen::Vector3d center = Eigen::Vector3d::Zero();
        center[second] = side * box.size[second];
        center[third] = other * box.size[third];
        result[count++] = bar(box, center, axis, box.size[axis], width);
      }
    }
  }
  const double reach = (0.5 + kHeadingReach) * box.size.x();
  result[count] = bar(box, {0.5 * reach, 0, 0}, 0, reach, width);
  return result;
}

void append_header(std::string& text, std::size_t boxes) {
  text +=
      "ply\nformat ascii 1.0\ncomment boxes as bars: 12 edges and a heading mark each\n"
      "element vertex " +
      std::to_string(boxes * kBarsOfABox * kCornersOfABar) +
      "\nproperty double x\nproperty double y\nproperty double z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
      std::to_string(boxes * kBarsOfABox * kTrianglesOfABar) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

TriangleMesh wireframe_mesh(const Box& box, double thickness) {
  if (!(thickness > 0.0 && thickness < 1.0)) {
    throw InvalidArgument("wireframe_mesh: expected a thickness in (0, 1), got " +
                          std::to_string(thickness));
  }
  geometry::require_valid(box, "wireframe_mesh");
  TriangleMesh mesh;
  for (const Box& part : bars(box, thickness)) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Eigen::Vector3d& corner : geometry::corners(part)) mesh.vertices.push_back(corner);
    for (const auto& [a, b, c] : kTriangles) {
      mesh.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return mesh;
}

std::string format_wireframes_ply(std::span<const geometry::Detection> detections,
                                  const std::function<RgbBytes(std::string_view)>& color_of_class,
                                  double thickness) {
  std::string text, faces;
  append_header(text, detections.size());
  std::uint32_t first = 0;
  for (const auto& detection : detections) {
    const TriangleMesh mesh = wireframe_mesh(detection.box, thickness);
    const auto [red, green, blue] = color_of_class(detection.label);
    const std::string color =
        std::to_string(red) + ' ' + std::to_string(green) + ' ' + std::to_string(blue) + '\n';
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      for (const double coordinate : vertex) {
        internal::append_fixed(text, coordinate, 6);
        text += ' ';
      }
      text += color;
    }
    for (const auto& triangle : mesh.triangles) {
      faces += '3';
      for (const std::uint32_t corner : triangle) faces += ' ' + std::to_string(first + corner);
      faces += '\n';
    }
    first += static_cast<std::uint32_t>(mesh.vertices.size());
  }
  return text + faces;
}

}  // namespace arbox::io
