#pragma once

#include <ATen/core/Tensor.h>

#include <span>

#include "arbox/sparse/point_search.h"

/// \file
/// Point-set operations on tensors: PV-RCNN's and PointNet++'s building blocks. Points are (N, 3)
/// float32 in metres; indices are int64 and have no gradient. What chooses points (furthest_points,
/// ball_query, points_in_boxes) runs on the CPU wherever its tensors live; what moves features runs
/// on their device. Shapes that do not fit throw InvalidArgument.

namespace arbox::sparse {

/// (count) indices; see furthest_points(span, count).
at::Tensor furthest_points(const at::Tensor& points, std::int64_t count);

/// (M, samples) indices into `points`, -1 for a centre without a neighbour. With `point_counts` and
/// `centre_counts` (one entry a scene, summing to N and M) a centre sees only its scene's points.
at::Tensor ball_query(const at::Tensor& points, const at::Tensor& centres, const BallQuery& query,
                      std::span<const std::int64_t> point_counts = {},
                      std::span<const std::int64_t> centre_counts = {});

/// features (N, C) at index (M, S): (M, S, C), rows of zeros at -1. Differentiable.
at::Tensor group(const at::Tensor& features, const at::Tensor& index);

/// map (B, C, H, W) at places (M, 3): batch, x and y in cells: (M, C), bilinear. The four corners
/// are clamped to the map and the weights use the clamped corners, so that they vanish at and
/// beyond the far border, as in PV-RCNN. Differentiable in the map.
at::Tensor sample_birds_eye(const at::Tensor& map, const at::Tensor& places);

/// Boxes (R, 10) to (R, cells^3, 3): the centres of a cells x cells x cells grid inside each box,
/// ((i + 1/2) / cells - 1/2) * size turned with the box, x slowest and z fastest. Differentiable.
at::Tensor roi_grid_points(const at::Tensor& boxes, std::int64_t cells);

/// (N) the lowest row of boxes (M, 10) that holds each point, or -1; see box_of_points.
at::Tensor points_in_boxes(const at::Tensor& points, const at::Tensor& boxes, double margin = 0);

}  // namespace arbox::sparse
