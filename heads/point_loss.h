#pragma once

#include <ATen/core/Tensor.h>

namespace arbox::heads {

enum class PointLoss { kL1, kSmoothL1 };

/// Absolute value of each difference, or with kSmoothL1 (Huber's) d^2 / (2 beta) below beta and
/// |d| - beta / 2 above.
at::Tensor point_loss(const at::Tensor& difference, PointLoss loss, double beta);

}  // namespace arbox::heads
