#pragma once

#include <ATen/core/Tensor.h>

#include "arbox/detectors/pv_rcnn/options.h"

/// \file
/// Boxes of PV-RCNN: rows (..., 7) of x y z l w h yaw, metres and radians, z of the centre. Between
/// rooms boxes are (..., 10), see heads/box_tensor.h.
///
/// Residuals of a box g to a reference a, with d = sqrt(l_a^2 + w_a^2): (x_g - x_a) / d,
/// (y_g - y_a) / d, (z_g - z_a) / h_a, ln(l_g / l_a), ln(w_g / w_a), ln(h_g / h_a), yaw_g - yaw_a
/// (Lang et al., CVPR 2019; Shi et al., CVPR 2020). Everything is differentiable.

namespace arbox::detectors::pv_rcnn {

inline constexpr std::int64_t kBoxNumbers = 7;

/// Cells of the map that the first stage's anchors stand on, {along x, along y}.
std::array<std::int64_t, 2> anchor_cells(const Options& options);

/// (A, 7) float32 on the CPU. Row ((y * cells_x + x) * classes + class) * rotations + rotation.
at::Tensor make_anchors(const Options& options);

/// Residuals of boxes (..., 7) to anchors (..., 7). Sizes below 1e-5 m count as 1e-5 m. The
/// difference of yaws is not wrapped.
at::Tensor encode_residuals(const at::Tensor& boxes, const at::Tensor& anchors);

/// The boxes that encode to the residuals.
at::Tensor decode_residuals(const at::Tensor& residuals, const at::Tensor& anchors);

/// Residuals in the frame of regions of interest (R, 7): the centre's difference is turned into the
/// region's axes first. Yaw differences are wrapped into [-pi, pi).
at::Tensor encode_region_residuals(const at::Tensor& boxes, const at::Tensor& regions);

/// The boxes (R, 7) that encode to residuals (R, 7) in the frame of regions (R, 7).
at::Tensor decode_region_residuals(const at::Tensor& residuals, const at::Tensor& regions);

/// Yaws (N) known up to half a turn, and logits (N, 2) of the two directions, to yaws in
/// [offset, offset + 2 pi).
at::Tensor resolve_directions(const at::Tensor& yaws, const at::Tensor& directions, double offset);

/// (N) int64: the direction, 0 or 1, that resolve_directions must be given for these yaws.
at::Tensor direction_of(const at::Tensor& yaws, double offset);

/// (..., 7) to (..., 10) and back; roll and pitch of the latter are ignored.
at::Tensor to_box_rows(const at::Tensor& boxes);
at::Tensor from_box_rows(const at::Tensor& rows);

}  // namespace arbox::detectors::pv_rcnn
