#pragma once

#include <ATen/core/Tensor.h>

namespace arbox::heads::internal {

/// Hamilton product of quaternions (..., 4), w first; broadcasts.
at::Tensor quaternion_product(const at::Tensor& a, const at::Tensor& b);
/// (..., 4) -> its conjugate.
at::Tensor quaternion_conjugate(const at::Tensor& q);
/// Vectors (..., 3) turned by unit quaternions (..., 4); broadcasts.
at::Tensor rotate(const at::Tensor& q, const at::Tensor& v);
/// Rotation about +z by `yaw` (...): (..., 4).
at::Tensor yaw_quaternion(const at::Tensor& yaw);
/// Heading (...) of unit quaternions (..., 4), in [-pi, pi].
at::Tensor yaw_of(const at::Tensor& q);
/// angle - period * floor((angle - low) / period): wrapped into [low, low + period).
at::Tensor wrap(const at::Tensor& angle, double low, double period);
/// R = Rz(alpha) Ry(beta) Rz(gamma): angles (..., 3) -> quaternions (..., 4).
at::Tensor zyz_quaternion(const at::Tensor& angles);
/// The inverse: alpha and gamma in [0, 2 pi), beta in [0, pi]; gamma is 0 where beta is 0 or pi.
at::Tensor zyz_of(const at::Tensor& q);

}  // namespace arbox::heads::internal
