#include "arbox/detectors/pv_rcnn/box_coding.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/atan2.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/clamp.h>
#include <ATen/ops/cos.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/exp.h>
#include <ATen/ops/floor.h>
#include <ATen/ops/log.h>
#include <ATen/ops/sin.h>
#include <ATen/ops/sqrt.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros_like.h>

#include <numbers>

#include "arbox/detectors/pv_rcnn/internal/map_cells.h"

namespace arbox::detectors::pv_rcnn {

using at::Tensor;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLeastSize = 1e-5;

/// v in [low, low + period).
Tensor wrap(const Tensor& v, double low, double period) {
  return v - at::floor((v - low) / period) * period;
}

Tensor column(const Tensor& boxes, std::int64_t i) { return boxes.select(-1, i); }

/// Of sizes (..., 3), seen from above.
Tensor ground_diagonal(const Tensor& sizes) {
  return at::sqrt(column(sizes, 0).square() + column(sizes, 1).square());
}

}  // namespace

internal::MapCells internal::map_cells(const Options& options) {
  const BackboneOptions& backbone = options.backbone;
  const auto voxels = options.voxels.grid();
  MapCells cells{{voxels[0], voxels[1], voxels[2] + backbone.height_margin}, 1};
  const int kernel = backbone.down_kernel;
  for (std::size_t level = 1; level < backbone.channels.size(); ++level) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool padded = kernel == 3 && (axis < 2 || backbone.vertical_padding[level - 1] > 0);
      cells.grid[axis] = (cells.grid[axis] + (padded ? 2 : 0) - kernel) / 2 + 1;
    }
    cells.stride *= 2;
  }
  cells.grid[2] = cells.grid[2] < backbone.out_kernel
                      ? 0
                      : (cells.grid[2] - backbone.out_kernel) / backbone.out_stride + 1;
  return cells;
}

std::array<std::int64_t, 2> anchor_cells(const Options& options) {
  const auto cells = internal::map_cells(options);
  const std::int64_t stride = options.birds_eye.strides.front();
  return {(cells.grid[0] + 2 - 3) / stride + 1, (cells.grid[1] + 2 - 3) / stride + 1};
}

Tensor make_anchors(const Options& options) {
  const AnchorOptions& anchors = options.anchors;
  const auto [cells_x, cells_y] = anchor_cells(options);
  const auto place = [&](int axis, std::int64_t i, std::int64_t cells) {
    const double low = options.voxels.low[axis], span = options.voxels.high[axis] - low;
    if (anchors.on_borders && cells > 1) return low + span * i / (cells - 1);
    return low + span * (i + 0.5) / cells;
  };
  const std::size_t classes = anchors.lengths.size();
  Tensor result = at::empty({cells_y * cells_x * static_cast<std::int64_t>(classes) *
                                 static_cast<std::int64_t>(anchors.rotations.size()),
                             kBoxNumbers},
                            at::kFloat);
  float* to = result.data_ptr<float>();
  for (std::int64_t y = 0; y < cells_y; ++y) {
    for (std::int64_t x = 0; x < cells_x; ++x) {
      for (std::size_t c = 0; c < classes; ++c) {
        for (const double rotation : anchors.rotations) {
          for (const double number :
               {place(0, x, cells_x), place(1, y, cells_y),
                anchors.bottoms[c] + 0.5 * anchors.heights[c], anchors.lengths[c],
                anchors.widths[c], anchors.heights[c], rotation}) {
            *to++ = static_cast<float>(number);
          }
        }
      }
    }
  }
  return result;
}

Tensor encode_residuals(const Tensor& boxes, const Tensor& anchors) {
  const Tensor size = at::clamp(boxes.slice(-1, 3, 6), kLeastSize);
  const Tensor from = at::clamp(anchors.slice(-1, 3, 6), kLeastSize);
  const Tensor d = ground_diagonal(from);
  const Tensor scale = at::stack({d, d, column(from, 2)}, -1);
  return at::cat({(boxes.slice(-1, 0, 3) - anchors.slice(-1, 0, 3)) / scale, at::log(size / from),
                  boxes.slice(-1, 6, 7) - anchors.slice(-1, 6, 7)},
                 -1);
}

Tensor decode_residuals(const Tensor& residuals, const Tensor& anchors) {
  const Tensor d = ground_diagonal(anchors.slice(-1, 3, 6));
  const Tensor scale = at::stack({d, d, column(anchors, 5)}, -1);
  return at::cat({residuals.slice(-1, 0, 3) * scale + anchors.slice(-1, 0, 3),
                  at::exp(residuals.slice(-1, 3, 6)) * anchors.slice(-1, 3, 6),
                  residuals.slice(-1, 6, 7) + anchors.slice(-1, 6, 7)},
                 -1);
}

Tensor encode_region_residuals(const Tensor& boxes, const Tensor& regions) {
  const Tensor yaw = column(regions, 6), c = at::cos(yaw), s = at::sin(yaw);
  const Tensor dx = column(boxes, 0) - column(regions, 0);
  const Tensor dy = column(boxes, 1) - column(regions, 1);
  const Tensor local =
      at::stack({c * dx + s * dy, c * dy - s * dx, column(boxes, 2) - column(regions, 2)}, -1);
  const Tensor turn = wrap(column(boxes, 6) - yaw, -kPi, 2 * kPi).unsqueeze(-1);
  const Tensor zero = at::zeros_like(local);
  return encode_residuals(at::cat({local, boxes.slice(-1, 3, 6), turn}, -1),
                          at::cat({zero, regions.slice(-1, 3, 6), zero.slice(-1, 0, 1)}, -1));
}

Tensor decode_region_residuals(const Tensor& residuals, const Tensor& regions) {
  const Tensor zero = at::zeros_like(regions.slice(-1, 0, 3));
  const Tensor local = decode_residuals(
      residuals, at::cat({zero, regions.slice(-1, 3, 6), zero.slice(-1, 0, 1)}, -1));
  const Tensor yaw = column(regions, 6), c = at::cos(yaw), s = at::sin(yaw);
  const Tensor x = column(local, 0), y = column(local, 1);
  return at::stack({c * x - s * y + column(regions, 0), s * x + c * y + column(regions, 1),
                    column(local, 2) + column(regions, 2), column(local, 3), column(local, 4),
                    column(local, 5), column(local, 6) + yaw},
                   -1);
}

Tensor resolve_directions(const Tensor& yaws, const Tensor& directions, double offset) {
  return wrap(yaws, offset, kPi) + directions.argmax(-1).to(yaws.scalar_type()) * kPi;
}

Tensor direction_of(const Tensor& yaws, double offset) {
  return at::clamp(at::floor((wrap(yaws, offset, 2 * kPi) - offset) / kPi), 0, 1).to(at::kLong);
}

Tensor to_box_rows(const Tensor& boxes) {
  const Tensor half = 0.5 * boxes.slice(-1, 6, 7), zero = at::zeros_like(half);
  return at::cat({boxes.slice(-1, 0, 6), at::cos(half), zero, zero, at::sin(half)}, -1);
}

Tensor from_box_rows(const Tensor& rows) {
  const Tensor w = column(rows, 6), x = column(rows, 7), y = column(rows, 8), z = column(rows, 9);
  const Tensor yaw = at::atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z);
  return at::cat({rows.slice(-1, 0, 6), yaw.unsqueeze(-1)}, -1);
}

}  // namespace arbox::detectors::pv_rcnn
