#include "arbox/geometry/internal/enclosing.h"

#include <array>
#include <cmath>

#include "arbox/geometry/internal/rectangle.h"
#include "arbox/geometry/rotation.h"

namespace arbox::geometry::internal {
namespace {

// Gains below this part of the volume are not worth a step.
constexpr double kGain = 1e-9;

Quaternion turn_about(int axis, double angle) {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  direction[axis] = std::sin(0.5 * angle);
  return {std::cos(0.5 * angle), direction.x(), direction.y(), direction.z()};
}

/// Names the axes anew so that own axis `axis` becomes z.
Quaternion with_axis_as_z(const Quaternion& rotation, int axis) {
  static const std::array<Quaternion, 3> renamings = {
      Quaternion(0.5, 0.5, 0.5, 0.5), Quaternion(0.5, -0.5, -0.5, -0.5), Quaternion(1, 0, 0, 0)};
  return rotation * renamings[axis];
}

class Descent {
 public:
  Descent(const PointSet& points, const Box& start, double least_size)
      : points_(points),
        least_size_(least_size),
        best_(start),
        least_(clamped_volume(start.size, least_size)) {}

  Box run(const TiltSteps& steps) {
    settle();
    double step = steps.first;
    while (step > steps.last) {
      if (tilt(step)) {
        settle();
      } else {
        step *= 0.5;
      }
    }
    return best_;
  }

 private:
  bool improve(const Quaternion& rotation) {
    const Box box = smallest_about(points_, rotation, least_size_);
    const double volume = clamped_volume(box.size, least_size_);
    if (!(volume < least_ * (1.0 - kGain))) return false;
    best_ = box;
    least_ = volume;
    return true;
  }

  /// Turns about each own axis, exactly, until no such turn helps.
  void settle() {
    for (int failures = 0, axis = 0; failures < 3; axis = (axis + 1) % 3) {
      failures = improve(with_axis_as_z(best_.rotation, axis)) ? 0 : failures + 1;
    }
  }

  bool tilt(double step) {
    for (int axis = 0; axis < 3; ++axis) {
      const Quaternion frame = with_axis_as_z(best_.rotation, axis);
      for (const int about : {0, 1}) {
        for (const double angle : {step, -step}) {
          if (improve((frame * turn_about(about, angle)).normalized())) return true;
        }
      }
    }
    return false;
  }

  const PointSet& points_;
  double least_size_;
  Box best_;
  double least_;
};

}  // namespace

double clamped_volume(const Eigen::Vector3d& size, double least_size) {
  return size.cwiseMax(least_size).prod();
}

Box box_about(const PointSet& points, const Quaternion& rotation) {
  const RotationRows rows = rows_of(rotation);
  Extents extents = empty_extents();
  widen(points, {&rows, 1}, {&extents, 1});
  return box_of(extents, rotation, Eigen::Vector3d::Zero());
}

Box smallest_about(const PointSet& points, const Quaternion& rotation, double least_size) {
  const Eigen::Matrix3d axes = rotation.toRotationMatrix();
  std::vector<Eigen::Vector2d> projected(points.count);
  for (std::size_t i = 0; i < points.count; ++i) {
    projected[i] = axes.leftCols<2>().transpose() * points[i];
  }
  const double angle = least_rectangle(projected, least_size).angle;
  return box_about(points, (rotation * turn_about(2, angle)).normalized());
}

Box descend(const PointSet& points, const Box& start, const TiltSteps& steps, double least_size) {
  return nearest_equivalent(Descent(points, start, least_size).run(steps), start.rotation);
}

}  // namespace arbox::geometry::internal
