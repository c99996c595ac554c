#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <span>

#include "arbox/geometry/box.h"

/// \file
/// Rotations of boxes: Euler angles, distances, and the symmetries of a box. A box has no front:
/// its axes can be renamed and turned in 24 ways (the proper rotations of a cube) that change the
/// numbers of size and rotation, and leave the box where it is.

namespace arbox::geometry {

/// R = Rz(alpha) Ry(beta) Rz(gamma), radians.
struct ZyzAngles {
  double alpha = 0.0;
  double beta = 0.0;
  double gamma = 0.0;
};

/// R = Rz(yaw) Ry(pitch) Rx(roll), radians.
struct RollPitchYaw {
  double roll = 0.0;
  double pitch = 0.0;
  double yaw = 0.0;
};

/// Any finite angles are accepted.
Quaternion to_quaternion(const ZyzAngles& angles);
Quaternion to_quaternion(const RollPitchYaw& angles);

/// ZYZ angles of a unit quaternion: alpha and gamma in [0, 2 pi), beta in [0, pi]. Where beta is 0
/// or pi only alpha + gamma or alpha - gamma is defined: gamma is then 0.
ZyzAngles zyz_angles(const Quaternion& rotation);

/// Roll-pitch-yaw angles of a unit quaternion: roll and yaw in (-pi, pi], pitch in
/// [-pi / 2, pi / 2]. Where the pitch is a quarter turn only yaw - roll or yaw + roll is defined:
/// roll is then 0.
RollPitchYaw roll_pitch_yaw(const Quaternion& rotation);

/// Which renamings of a box's own axes count as the same box.
enum class BoxSymmetry {
  /// None: the axes have a meaning (a heading).
  kNone,
  /// The 4 turns by 0 or pi about an own axis: the sizes stay in their order.
  kHalfTurns,
  /// All 24 proper rotations of the frame, with the sizes permuted to match.
  kFrame,
};

/// The rotations of the symmetry, identity first: 1, 4 or 24 unit quaternions; the half turns are
/// the first four of the 24. Each maps the axes of a box onto its axes.
std::span<const Quaternion> symmetry_rotations(BoxSymmetry symmetry);

/// The boxes that fill the same space as `box`, in the order of symmetry_rotations(kFrame): box i
/// has rotation box.rotation * symmetry i and the sizes permuted to match. The first is `box`.
std::array<Box, 24> equivalent_boxes(const Box& box);

/// The equivalent box whose rotation is nearest to `reference`; the first one in the order of
/// symmetry_rotations() if several are equally near.
Box nearest_equivalent(const Box& box, const Quaternion& reference,
                       BoxSymmetry symmetry = BoxSymmetry::kFrame);

/// Angle of the rotation that leads from `first` to `second`, radians in [0, pi]; with a symmetry
/// the least over the renamings of axes (at most 62.8 degrees for kFrame).
double rotation_distance(const Quaternion& first, const Quaternion& second,
                         BoxSymmetry symmetry = BoxSymmetry::kNone);

/// The smallest box along the frame's axes that contains `box`.
Eigen::AlignedBox3d axis_aligned_hull(const Box& box);

}  // namespace arbox::geometry
