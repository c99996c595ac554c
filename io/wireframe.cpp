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
constexpr int kTriangles[kTrianglesOfABar][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},
                                                 {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                                 {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};

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

void append_vertices(std::string& text, const Box& box, const std::string& color) {
  for (const Eigen::Vector3d& corner : geometry::corners(box)) {
    for (const double coordinate : corner) {
      internal::append_fixed(text, coordinate, 6);
      text += ' ';
    }
    text += color;
  }
}

void append_faces(std::string& text, std::size_t first) {
  for (const auto& triangle : kTriangles) {
    text += '3';
    for (const int corner : triangle) {
      text.append(" ").append(std::to_string(first + static_cast<std::size_t>(corner)));
    }
    text += '\n';
  }
}

}  // namespace

std::string format_wireframes_ply(std::span<const geometry::Detection> detections,
                                  const std::function<RgbBytes(std::string_view)>& color_of_class,
                                  double thickness) {
  if (!(thickness > 0.0 && thickness < 1.0)) {
    throw InvalidArgument("format_wireframes_ply: expected a thickness in (0, 1), got " +
                          std::to_string(thickness));
  }
  std::string text;
  append_header(text, detections.size());
  for (const auto& detection : detections) {
    geometry::require_valid(detection.box, "format_wireframes_ply");
    const auto [red, green, blue] = color_of_class(detection.label);
    const std::string color =
        std::to_string(red) + ' ' + std::to_string(green) + ' ' + std::to_string(blue) + '\n';
    for (const Box& part : bars(detection.box, thickness)) append_vertices(text, part, color);
  }
  for (std::size_t i = 0; i < detections.size() * kBarsOfABox; ++i) {
    append_faces(text, i * kCornersOfABar);
  }
  return text;
}

}  // namespace arbox::io
