#include "arbox/geometry/box.h"

#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include "arbox/base/error.h"

namespace arbox::geometry {
namespace {

bool is_valid(const Box& box) {
  return box.center.allFinite() && box.size.allFinite() && (box.size.array() > 0.0).all() &&
         std::abs(box.rotation.norm() - 1.0) <= 1e-6;
}

std::string violation(const Box& box) {
  std::ostringstream text;
  if (!box.center.allFinite()) {
    text << "center is not finite: " << box.center.transpose();
  } else if (!box.size.allFinite() || (box.size.array() <= 0.0).any()) {
    text << "sizes must be finite and above zero, got " << box.size.transpose();
  } else {
    text << "rotation must be a unit quaternion, its norm is " << box.rotation.norm();
  }
  return text.str();
}

}  // namespace

Box make_yaw_box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw) {
  return {.center = center,
          .size = size,
          .rotation = {std::cos(0.5 * yaw), 0.0, 0.0, std::sin(0.5 * yaw)}};
}

bool is_yaw_only(const Box& box, double tolerance) {
  const auto& q = box.rotation;
  return 2.0 * std::hypot(q.x(), q.y()) * std::hypot(q.z(), q.w()) <= tolerance &&
         std::hypot(q.x(), q.y()) < std::hypot(q.z(), q.w());
}

double yaw(const Box& box) {
  const auto& q = box.rotation;
  const double x = 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z());
  const double y = 2.0 * (q.x() * q.y() + q.w() * q.z());
  if (std::hypot(x, y) < 1e-12) return 0.0;
  return wrap_angle(std::atan2(y, x));
}

double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

void require_valid(const Box& box, std::string_view where) {
  if (!is_valid(box)) throw InvalidArgument(std::string(where) + ": " + violation(box));
}

void require_valid(std::span<const Box> boxes, std::string_view where) {
  for (std::size_t row = 0; row < boxes.size(); ++row) {
    if (is_valid(boxes[row])) continue;
    throw InvalidArgument(std::string(where) + ": box in row " + std::to_string(row) + ": " +
                          violation(boxes[row]));
  }
}

double volume(const Box& box) { return box.size.prod(); }

std::array<Eigen::Vector3d, 8> corners(const Box& box) {
  const Eigen::Matrix3d axes = box.rotation.toRotationMatrix() * (0.5 * box.size).asDiagonal();
  std::array<Eigen::Vector3d, 8> result;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d signs((i & 1) ? 1.0 : -1.0, (i & 2) ? 1.0 : -1.0, (i & 4) ? 1.0 : -1.0);
    result[i] = box.center + axes * signs;
  }
  return result;
}

bool contains(const Box& box, const Eigen::Vector3d& point, double tolerance) {
  const Eigen::Vector3d local = box.rotation.conjugate() * (point - box.center);
  return (local.array().abs() <= 0.5 * box.size.array() + tolerance).all();
}

Box transformed(const Box& box, const Eigen::Isometry3d& transform) {
  const Quaternion turn(Eigen::Quaterniond(transform.linear()));
  return {.center = transform * box.center,
          .size = box.size,
          .rotation = (turn * box.rotation).normalized()};
}

}  // namespace arbox::geometry
