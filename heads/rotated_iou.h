#pragma once

#include <ATen/core/Tensor.h>

/// \file
/// A differentiable overlap of boxes that stand upright, for losses. geometry/overlap.h computes
/// overlaps of any boxes where no gradient is needed.

namespace arbox::heads {

/// IoU of boxes (..., 7) with columns x y z l w h yaw: first, second -> (...), both of one shape.
///
/// Computed in double whatever the dtype. The gradient with respect to both is exact wherever the
/// IoU is differentiable: the intersection's area changes with an edge's speed outwards times the
/// length of edge that bounds it. Where faces coincide each box bounds half, which lies between the
/// one-sided derivatives; coincident boxes have gradient 0. Zero, with gradient zero, for boxes
/// that do not overlap, that only touch, and for sizes that are not above zero. About a microsecond
/// a pair with gradient. Throws InvalidArgument for other shapes.
at::Tensor rotated_iou(const at::Tensor& first, const at::Tensor& second);

/// Box tensor (..., 10) -> (..., 7): x y z l w h yaw, with gradient. Roll and pitch are ignored.
at::Tensor upright_boxes(const at::Tensor& boxes);

}  // namespace arbox::heads
