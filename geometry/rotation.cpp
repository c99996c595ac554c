#include "arbox/geometry/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arbox::geometry {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
// Sine of the angle below which the middle angle counts as degenerate.
constexpr double kGimbal = 1e-12;

double positive_turn(double angle) {
  const double wrapped = angle - kTurn * std::floor(angle / kTurn);
  return wrapped < kTurn ? wrapped : 0.0;
}

std::array<Quaternion, 24> make_frame_rotations() {
  std::array<Quaternion, 24> result;
  const double half = std::sqrt(0.5);
  const std::array<Quaternion, 6> bases = {Quaternion(1, 0, 0, 0),
                                           Quaternion(0.5, 0.5, 0.5, 0.5),
                                           Quaternion(0.5, -0.5, -0.5, -0.5),
                                           Quaternion(half, half, 0, 0),
                                           Quaternion(half, 0, half, 0),
                                           Quaternion(half, 0, 0, half)};
  const std::array<Quaternion, 4> half_turns = {Quaternion(1, 0, 0, 0), Quaternion(0, 1, 0, 0),
                                                Quaternion(0, 0, 1, 0), Quaternion(0, 0, 0, 1)};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = bases[i / 4] * half_turns[i % 4];
  return result;
}

Box renamed(const Box& box, const Quaternion& symmetry) {
  const Eigen::Matrix3d axes = symmetry.toRotationMatrix().array().round().matrix();
  return {.center = box.center,
          .size = axes.cwiseAbs().transpose() * box.size,
          .rotation = (box.rotation * symmetry).normalized()};
}

double cosine_of_half(const Quaternion& first, const Quaternion& second) {
  return std::abs(first.coeffs().dot(second.coeffs()));
}

double angle_between(const Quaternion& first, const Quaternion& second) {
  const Quaternion difference = first.conjugate() * second;
  return 2.0 * std::atan2(difference.vec().norm(), std::abs(difference.w()));
}

}  // namespace

Quaternion to_quaternion(const ZyzAngles& angles) {
  const double half_sum = 0.5 * (angles.alpha + angles.gamma);
  const double half_difference = 0.5 * (angles.alpha - angles.gamma);
  const double c = std::cos(0.5 * angles.beta);
  const double s = std::sin(0.5 * angles.beta);
  return {c * std::cos(half_sum), -s * std::sin(half_difference), s * std::cos(half_difference),
          c * std::sin(half_sum)};
}

Quaternion to_quaternion(const RollPitchYaw& angles) {
  const Quaternion roll(std::cos(0.5 * angles.roll), std::sin(0.5 * angles.roll), 0, 0);
  const Quaternion pitch(std::cos(0.5 * angles.pitch), 0, std::sin(0.5 * angles.pitch), 0);
  const Quaternion yaw(std::cos(0.5 * angles.yaw), 0, 0, std::sin(0.5 * angles.yaw));
  return yaw * pitch * roll;
}

ZyzAngles zyz_angles(const Quaternion& rotation) {
  const auto& q = rotation;
  const double tilt_sine = std::hypot(q.x(), q.y());
  const double tilt_cosine = std::hypot(q.w(), q.z());
  const double half_sum = std::atan2(q.z(), q.w());
  const double half_difference = std::atan2(-q.x(), q.y());
  if (tilt_sine < kGimbal) return {.alpha = positive_turn(2.0 * half_sum)};
  if (tilt_cosine < kGimbal) {
    return {.alpha = positive_turn(2.0 * half_difference), .beta = std::numbers::pi};
  }
  return {.alpha = positive_turn(half_sum + half_difference),
          .beta = 2.0 * std::atan2(tilt_sine, tilt_cosine),
          .gamma = positive_turn(half_sum - half_difference)};
}

RollPitchYaw roll_pitch_yaw(const Quaternion& rotation) {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  const double cosine = std::hypot(r(0, 0), r(1, 0));
  RollPitchYaw result{.pitch = std::atan2(-r(2, 0), cosine)};
  if (cosine < kGimbal) {
    result.yaw = wrap_angle(std::atan2(-r(0, 1), r(1, 1)));
    return result;
  }
  result.yaw = wrap_angle(std::atan2(r(1, 0), r(0, 0)));
  // The roll of what is left after undoing this very yaw: their errors cancel near the gimbal.
  const double s = std::sin(result.yaw);
  const double c = std::cos(result.yaw);
  result.roll = wrap_angle(std::atan2(s * r(0, 2) - c * r(1, 2), c * r(1, 1) - s * r(0, 1)));
  return result;
}

std::span<const Quaternion> symmetry_rotations(BoxSymmetry symmetry) {
  static const std::array<Quaternion, 24> rotations = make_frame_rotations();
  switch (symmetry) {
    case BoxSymmetry::kNone:
      return std::span(rotations).first(1);
    case BoxSymmetry::kHalfTurns:
      return std::span(rotations).first(4);
    case BoxSymmetry::kFrame:
      break;
  }
  return rotations;
}

std::array<Box, 24> equivalent_boxes(const Box& box) {
  const auto symmetries = symmetry_rotations(BoxSymmetry::kFrame);
  std::array<Box, 24> result;
  result[0] = box;
  for (std::size_t i = 1; i < result.size(); ++i) result[i] = renamed(box, symmetries[i]);
  return result;
}

Box nearest_equivalent(const Box& box, const Quaternion& reference, BoxSymmetry symmetry) {
  const auto symmetries = symmetry_rotations(symmetry);
  std::size_t best = 0;
  double best_cosine = cosine_of_half(box.rotation, reference);
  for (std::size_t i = 1; i < symmetries.size(); ++i) {
    const double cosine = cosine_of_half(box.rotation * symmetries[i], reference);
    // A margin above rounding, so that ties go to the first.
    if (cosine > best_cosine + 1e-14) {
      best = i;
      best_cosine = cosine;
    }
  }
  return best == 0 ? box : renamed(box, symmetries[best]);
}

double rotation_distance(const Quaternion& first, const Quaternion& second, BoxSymmetry symmetry) {
  double least = std::numbers::pi;
  for (const Quaternion& renaming : symmetry_rotations(symmetry)) {
    least = std::min(least, angle_between(first * renaming, second));
  }
  return least;
}

Eigen::AlignedBox3d axis_aligned_hull(const Box& box) {
  const Eigen::Vector3d half = 0.5 * (box.rotation.toRotationMatrix().cwiseAbs() * box.size);
  return {box.center - half, box.center + half};
}

}  // namespace arbox::geometry
