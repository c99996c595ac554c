#include "arbox/heads/internal/rotation_tensor.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/atan2.h>
#include <ATen/ops/cos.h>
#include <ATen/ops/cross.h>
#include <ATen/ops/floor.h>
#include <ATen/ops/hypot.h>
#include <ATen/ops/sin.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/where.h>
#include <ATen/ops/zeros_like.h>

#include <numbers>

namespace arbox::heads::internal {

using at::Tensor;

Tensor quaternion_product(const Tensor& a, const Tensor& b) {
  const Tensor aw = a.select(-1, 0), ax = a.select(-1, 1), ay = a.select(-1, 2),
               az = a.select(-1, 3);
  const Tensor bw = b.select(-1, 0), bx = b.select(-1, 1), by = b.select(-1, 2),
               bz = b.select(-1, 3);
  return at::stack({aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
                    aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw},
                   -1);
}

Tensor quaternion_conjugate(const Tensor& q) {
  return at::stack({q.select(-1, 0), -q.select(-1, 1), -q.select(-1, 2), -q.select(-1, 3)}, -1);
}

Tensor rotate(const Tensor& q, const Tensor& v) {
  const Tensor w = q.select(-1, 0), x = q.select(-1, 1), y = q.select(-1, 2), z = q.select(-1, 3);
  const Tensor vx = v.select(-1, 0), vy = v.select(-1, 1), vz = v.select(-1, 2);
  const Tensor tx = 2 * (y * vz - z * vy), ty = 2 * (z * vx - x * vz), tz = 2 * (x * vy - y * vx);
  return at::stack(
      {vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx},
      -1);
}

Tensor yaw_quaternion(const Tensor& yaw) {
  const Tensor zero = at::zeros_like(yaw);
  return at::stack({at::cos(0.5 * yaw), zero, zero, at::sin(0.5 * yaw)}, -1);
}

Tensor yaw_of(const Tensor& q) {
  const Tensor w = q.select(-1, 0), x = q.select(-1, 1), y = q.select(-1, 2), z = q.select(-1, 3);
  return at::atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z));
}

Tensor wrap(const Tensor& angle, double low, double period) {
  return angle - period * at::floor((angle - low) / period);
}

Tensor zyz_quaternion(const Tensor& angles) {
  const Tensor alpha = angles.select(-1, 0), half = 0.5 * angles.select(-1, 1),
               gamma = angles.select(-1, 2);
  const Tensor sum = 0.5 * (alpha + gamma), difference = 0.5 * (alpha - gamma);
  return at::stack({at::cos(half) * at::cos(sum), -at::sin(half) * at::sin(difference),
                    at::sin(half) * at::cos(difference), at::cos(half) * at::sin(sum)},
                   -1);
}

Tensor zyz_of(const Tensor& q) {
  const Tensor w = q.select(-1, 0), x = q.select(-1, 1), y = q.select(-1, 2), z = q.select(-1, 3);
  // Where beta is 0 or pi only one of the two angles is defined: gamma is 0 then, as in geometry.
  constexpr double kTie = 1e-6;
  const Tensor sine = at::hypot(x, y), cosine = at::hypot(w, z);
  const Tensor flat = sine < kTie, over = cosine < kTie;
  const Tensor given_sum = at::atan2(z.masked_fill(over, 0.0), w.masked_fill(over, 1.0));
  const Tensor given_difference = at::atan2(-x.masked_fill(flat, 0.0), y.masked_fill(flat, 1.0));
  const Tensor sum = at::where(over, given_difference, given_sum);
  const Tensor difference = at::where(flat, given_sum, given_difference);
  constexpr double turn = 2.0 * std::numbers::pi;
  return at::stack({wrap(sum + difference, 0.0, turn), 2 * at::atan2(sine, cosine),
                    wrap(sum - difference, 0.0, turn)},
                   -1);
}

}  // namespace arbox::heads::internal
