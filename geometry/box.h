#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <span>
#include <string_view>

/// \file
/// The 3-D box and its elementary operations. Conventions (frames, yaw sense, units) are defined in
/// docs/conventions.md: metres, radians, full sizes, yaw counter-clockwise about +z from +x.

namespace arbox::geometry {

/// Unaligned on purpose, so that the layout of Box does not depend on a caller's -march flags.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

/// A rectangular box of any rotation.
struct Box {
  /// Centre, metres.
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  /// Full extents along the box's own x (length), y (width) and z (height) axes, metres.
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  /// Unit quaternion that turns the box's own axes into the frame's.
  Quaternion rotation = Quaternion::Identity();
};

/// A box whose rotation is about +z.
Box make_yaw_box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw);

/// True if the box's own z axis is the frame's +z within `tolerance` (sine of the tilt).
bool is_yaw_only(const Box& box, double tolerance = 1e-9);

/// Angle of the box's own x axis about +z from +x, in (-pi, pi]: exact for yaw-only boxes, the
/// heading of the projected x axis otherwise (0 if it is vertical).
double yaw(const Box& box);

/// The angle wrapped into (-pi, pi].
double wrap_angle(double angle);

/// Throws InvalidArgument, naming `where`, unless every number is finite, every size is above zero
/// and the quaternion's norm is 1 within 1e-6.
void require_valid(const Box& box, std::string_view where);

/// require_valid for each box; the message also names the row.
void require_valid(std::span<const Box> boxes, std::string_view where);

double volume(const Box& box);

/// The eight corners. Corner i has the signs x: bit 0, y: bit 1, z: bit 2 of i (0 is minus).
std::array<Eigen::Vector3d, 8> corners(const Box& box);

/// True if the point lies in the box or within `tolerance` metres outside of its faces.
bool contains(const Box& box, const Eigen::Vector3d& point, double tolerance = 0.0);

/// The box moved by a rigid transform.
Box transformed(const Box& box, const Eigen::Isometry3d& transform);

}  // namespace arbox::geometry
