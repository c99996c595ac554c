#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "arbox/geometry/box.h"

/// \file
/// Small boxes around points. All give nothing for no points, refuse points that are not finite
/// with InvalidArgument that names the row, and grow sizes below `minimum_size` (metres, above 0)
/// to it about the centre, so that flat and single points have a valid box. Every point lies in the
/// box but for rounding (1e-15 of the coordinates).

namespace arbox::geometry {

inline constexpr double kMinimumBoxSize = 1e-6;

/// The smallest box that has one of the given rotations, the first of equally small ones. Throws
/// InvalidArgument for no rotations or ones that are not unit quaternions. O(points * rotations).
std::optional<Box> enclosing_box(std::span<const Eigen::Vector3d> points,
                                 std::span<const Quaternion> rotations,
                                 double minimum_size = kMinimumBoxSize);

/// The smallest of all boxes whose rotation is about +z: exact (rotating calipers). Its length is
/// at least its width, its yaw in (-pi / 2, pi / 2]. O(n log n).
std::optional<Box> minimum_volume_yaw_box(std::span<const Eigen::Vector3d> points,
                                          double minimum_size = kMinimumBoxSize);

/// A small box over all rotations, by local search from many starts.
///
/// Turning about one own axis is solved exactly: the smallest box with a given axis stands on the
/// rectangle of least area around the projected points. Starts are the frame's axes, the principal
/// axes, the directions between extreme points and an even cover of the half sphere; the best few
/// descend by exact turns about their own axes and by tilts that shrink to 1e-7 rad.
///
/// Guarantee: never larger than the axis-aligned box, the box along the principal axes or
/// minimum_volume_yaw_box(), and a local minimum: no turn about one of its own axes makes it
/// smaller. It is not proved to be the global minimum (O'Rourke's exact method is cubic); of 100
/// random sets of up to 800 points, 96 were at least as small as by CGAL's optimal_bounding_box and
/// the worst 0.07 % larger. Its first axis is the longest and its third the shortest.
/// O(10^4 n log n), single-threaded, no random numbers.
std::optional<Box> minimum_volume_box(std::span<const Eigen::Vector3d> points,
                                      double minimum_size = kMinimumBoxSize);

/// The box in outer's rotation whose faces have gone the given share of the way from those of the
/// smallest such box around `inner` to outer's own; what of `inner` lies outside of `outer` is cut
/// off. Share 1 gives `outer` itself; a larger share contains all smaller ones, but for sizes grown
/// to kMinimumBoxSize. Throws InvalidArgument for bad boxes and a share that is not in [0, 1].
Box box_between(const Box& inner, const Box& outer, double share);

}  // namespace arbox::geometry
