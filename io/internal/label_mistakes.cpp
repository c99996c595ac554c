#include "arbox/io/internal/label_mistakes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "arbox/geometry/overlap.h"

namespace arbox::io::internal {
namespace {

using geometry::Box;
using MaybeBox = std::optional<Box>;

constexpr double kMargin = 0.03;
// Close is half a size around.
constexpr double kShell = 1.5;
constexpr double kGround = 0.2;
constexpr double kFewPoints = 5.0;
// Boxes that overlap more cannot be told apart.
constexpr double kSameBox = 0.75;
constexpr double kClearly = 0.05;
constexpr std::size_t kLeastBoxes = 4;

Box upright(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw) {
  return geometry::make_yaw_box(center, size, yaw);
}

MaybeBox scaled(const LabeledObject& object, double factor) {
  Box box = object.box;
  box.size *= factor;
  return box;
}

MaybeBox moved(const LabeledObject& object, double heights) {
  Box box = object.box;
  box.center += box.rotation * Eigen::Vector3d(0, 0, heights * box.size.z()).eval();
  return box;
}

MaybeBox swapped(const LabeledObject& object) {
  Box box = object.box;
  std::swap(box.size.x(), box.size.y());
  return box;
}

MaybeBox other_sense(const LabeledObject& object) {
  const Box& box = object.box;
  if (!geometry::is_yaw_only(box)) return std::nullopt;
  return upright(box.center, box.size, -geometry::yaw(box));
}

MaybeBox from_degrees(const LabeledObject& object) {
  if (!object.written_yaw) return std::nullopt;
  return upright(object.box.center, object.box.size, *object.written_yaw * std::numbers::pi / 180);
}

MaybeBox turned(const LabeledObject& object, double quarters) {
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() =
      Eigen::AngleAxisd(quarters * std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).matrix();
  return geometry::transformed(object.box, turn);
}

/// A box of a camera frame (x right, y down, z forward) with KITTI's rotation_y as its yaw.
MaybeBox from_camera(const LabeledObject& object, double raised) {
  const Box& box = object.box;
  if (!geometry::is_yaw_only(box)) return std::nullopt;
  return upright({box.center.z(), -box.center.x(), -box.center.y() + raised * box.size.z()},
                 box.size, -geometry::yaw(box) - std::numbers::pi / 2);
}

MaybeBox in_unit(const LabeledObject& object, double factor) {
  Box box = object.box;
  box.center *= factor;
  box.size *= factor;
  return box;
}

struct Counts {
  double inside = 0, close = 0;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
};

Counts count(const PointGrid& points, const Box& box) {
  const Eigen::Matrix3d to_box = box.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d half = 0.5 * box.size;
  const Eigen::Vector2d grown = half.head<2>().array() + kMargin;
  const Eigen::Vector2d shell = kShell * half.head<2>().array() + kMargin;
  const double bottom = -half.z() + kGround * box.size.z();
  Counts counts;
  points.each_near({box.center.x(), box.center.y(), kShell * half.norm() + kMargin},
                   [&](const Eigen::Vector3f& point) {
                     const Eigen::Vector3d p = to_box * (point.cast<double>() - box.center);
                     if (p.z() < bottom || p.z() > half.z() + kMargin) return;
                     const Eigen::Array2d away = p.head<2>().cwiseAbs();
                     if ((away > shell.array()).any()) return;
                     if ((away > grown.array()).any()) {
                       ++counts.close;
                       return;
                     }
                     ++counts.inside;
                     counts.low = counts.low.cwiseMin(p.head<2>());
                     counts.high = counts.high.cwiseMax(p.head<2>());
                   });
  return counts;
}

}  // namespace

const std::vector<Mistake>& known_mistakes() {
  static const std::vector<Mistake> mistakes = {
      {"half sizes", "the sizes look like half of what they should be",
       "write full sizes: multiply length, width and height by 2",
       [](const LabeledObject& object) { return scaled(object, 2.0); }},
      {"double sizes", "the sizes look like twice what they should be",
       "divide length, width and height by 2",
       [](const LabeledObject& object) { return scaled(object, 0.5); }},
      {"swapped sizes", "length and width look swapped (or the yaw is a quarter turn off)",
       "length is along the box's x axis, where yaw points: swap the two, or add pi/2 to yaw",
       [](const LabeledObject& object) { return swapped(object); }},
      {"yaw sense", "the yaw looks as if it ran clockwise",
       "yaw runs counter-clockwise about +z: turn its sign", other_sense},
      {"degrees", "the yaw looks as if it were in degrees", "write radians: multiply by pi/180",
       from_degrees},
      {"frame", "the labels look as if they stood in a camera's frame (x right, y down, z forward)",
       "bring them into the cloud's frame, or use KITTI's layout with calibrations",
       [](const LabeledObject& object) { return from_camera(object, 0.0); }},
      {"frame", "the labels look like KITTI's: a camera's frame and the centre of the bottom face",
       "bring them into the cloud's frame, or use KITTI's layout with calibrations",
       [](const LabeledObject& object) { return from_camera(object, 0.5); }},
      {"frame", "the labels look turned against the cloud by a quarter turn, counter-clockwise",
       "turn them by -90 degrees about z: (x, y) becomes (y, -x) and yaw loses pi/2",
       [](const LabeledObject& object) { return turned(object, -1.0); }},
      {"frame", "the labels look turned against the cloud by a quarter turn, clockwise",
       "turn them by 90 degrees about z: (x, y) becomes (-y, x) and yaw gains pi/2",
       [](const LabeledObject& object) { return turned(object, 1.0); }},
      {"frame", "the labels look turned against the cloud by half a turn",
       "turn them by 180 degrees about z: (x, y) becomes (-x, -y) and yaw gains pi",
       [](const LabeledObject& object) { return turned(object, 2.0); }},
      {"bottom centre", "the places look like centres of the bottom faces",
       "write centres of boxes: add half of the height to z",
       [](const LabeledObject& object) { return moved(object, 0.5); }},
      {"unit", "the labels look as if they were in millimetres",
       "write metres: divide places and sizes by 1000",
       [](const LabeledObject& object) { return in_unit(object, 0.001); }},
      {"unit", "the clouds look as if they were in millimetres, the labels in metres",
       "write clouds in metres: divide coordinates by 1000",
       [](const LabeledObject& object) { return in_unit(object, 1000.0); }}};
  return mistakes;
}

double fit(const PointGrid& points, const Box& box) {
  const Counts counts = count(points, box);
  if (counts.inside == 0) return 0.0;
  const double share = counts.inside / (counts.inside + counts.close + kFewPoints);
  const Eigen::Array2d span =
      ((counts.high - counts.low).array() / box.size.head<2>().array()).min(1.0);
  return share * std::sqrt(span.prod());
}

Square around(const Box& box) {
  const double reach = (0.5 * box.size.array() + kMargin).matrix().norm();
  return {box.center.x(), box.center.y(), reach};
}

std::size_t points_inside(const PointGrid& points, const Box& box, std::size_t enough) {
  const Eigen::Matrix3d to_box = box.rotation.conjugate().toRotationMatrix();
  const Eigen::Array3d half = 0.5 * box.size.array() + kMargin;
  std::size_t inside = 0;
  points.each_near(around(box), [&](const Eigen::Vector3f& point) {
    if (inside >= enough) return;
    const Eigen::Vector3d p = to_box * (point.cast<double>() - box.center);
    if ((p.array().abs() <= half).all()) ++inside;
  });
  return inside;
}

std::vector<Evidence> weigh(const PointGrid& points, const LabeledObject& object) {
  const auto& mistakes = known_mistakes();
  std::vector<Evidence> evidence(mistakes.size());
  const double as_it_is = fit(points, object.box);
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    const MaybeBox box = mistakes[i].undone(object);
    if (!box || !(box->size.array() > 1e-3).all()) continue;
    if (geometry::overlap(object.box, *box) > kSameBox) continue;
    const double gain = fit(points, *box) - as_it_is;
    evidence[i] = {.boxes = 1,
                   .better = gain > kClearly ? 1u : 0u,
                   .worse = gain < -kClearly ? 1u : 0u,
                   .gain = gain};
  }
  return evidence;
}

std::optional<std::size_t> likely_mistake(const std::vector<Evidence>& evidence) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const Evidence& one = evidence[i];
    if (one.better < kLeastBoxes || one.better < 2 * one.worse) continue;
    if (one.gain < kClearly * static_cast<double>(one.boxes)) continue;
    if (!best || one.gain > evidence[*best].gain) best = i;
  }
  return best;
}

}  // namespace arbox::io::internal
