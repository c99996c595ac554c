#pragma once

#include <ATen/core/Tensor.h>

#include <span>
#include <vector>

#include "arbox/geometry/box.h"

/// \file
/// Boxes as tensors. Between rooms a batch of boxes is a tensor of shape (..., 10) with the columns
/// x y z l w h qw qx qy qz (metres, full sizes, unit quaternion); yaw-only boxes have qx = qy = 0.

namespace arbox::heads {

/// Columns of a box tensor.
inline constexpr std::int64_t kBoxColumns = 10;

/// (boxes.size(), 10) on the CPU; kFloat or kDouble. No boxes give shape (0, 10).
at::Tensor to_tensor(std::span<const geometry::Box> boxes, at::ScalarType type = at::kFloat);

/// The rows of a (N, 10) tensor, quaternions normalised in double. Rows with a non-finite number or
/// a size that is not above zero are refused with NumericalError that names the row; another shape
/// with InvalidArgument.
std::vector<geometry::Box> to_boxes(const at::Tensor& tensor);

/// Throws InvalidArgument, naming `where` and both shapes, unless the last dimension is 10.
void require_boxes(const at::Tensor& tensor, const char* where);

}  // namespace arbox::heads
