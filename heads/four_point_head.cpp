#include "arbox/heads/four_point_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/diag_embed.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "arbox/base/options.h"
#include "arbox/geometry/rotation.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/rotation_tensor.h"
#include "arbox/heads/multilayer_perceptron.h"
#include "arbox/heads/point_distribution.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr double kLeastSize = 1e-3;

/// (24, 3, 3): the proper renamings of a box's axes.
Tensor make_renamings() {
  const auto symmetries = geometry::symmetry_rotations(geometry::BoxSymmetry::kFrame);
  Tensor result = at::empty({static_cast<std::int64_t>(symmetries.size()), 3, 3}, at::kDouble);
  double* number = result.data_ptr<double>();
  for (const geometry::Quaternion& rotation : symmetries) {
    const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) *number++ = std::round(matrix(row, column));
    }
  }
  return result;
}

const Tensor& renamings() {
  static const Tensor table = make_renamings();
  return table;
}

/// The corner and its neighbours, (..., 4, 3), of a centre (..., 3) and half axes (..., 3, 3) that
/// are columns.
Tensor four_corners(const Tensor& center, const Tensor& half_axes) {
  const Tensor corner = center - half_axes.sum(-1);
  const Tensor neighbours = corner.unsqueeze(-2) + 2 * half_axes.transpose(-1, -2);
  return at::cat({corner.unsqueeze(-2), neighbours}, -2);
}

Tensor largest_size(const References& references) {
  return references.size.amax(-1).clamp_min(kLeastSize);
}

geometry::Box box_of(const Eigen::Matrix<double, 4, 3, Eigen::RowMajor>& points) {
  // A trace of the frame's own axes keeps coincident points from having no direction at all.
  constexpr double kTrace = 1e-9;
  Eigen::Matrix3d edges;
  for (int axis = 0; axis < 3; ++axis) {
    edges.col(axis) =
        (points.row(axis + 1) - points.row(0)).transpose() + kTrace * Eigen::Vector3d::Unit(axis);
  }
  Eigen::Matrix3d axes;
  axes.col(0) = edges.col(0).normalized();
  axes.col(1) = (edges.col(1) - edges.col(1).dot(axes.col(0)) * axes.col(0)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  geometry::Box box;
  box.center = 0.5 * (points.colwise().sum() - 2 * points.row(0)).transpose();
  for (int axis = 0; axis < 3; ++axis) {
    box.size[axis] = std::max(std::abs(edges.col(axis).dot(axes.col(axis))), kLeastSize);
  }
  box.rotation = Eigen::Quaterniond(axes).normalized();
  return box;
}

}  // namespace

Tensor corner_assignments(const Tensor& boxes, const References& references) {
  require_boxes(boxes, "corner_assignments");
  const Tensor back = internal::quaternion_conjugate(references.rotation);
  const Tensor turn = internal::quaternion_product(back, boxes.slice(-1, 6, 10));
  const Tensor center = internal::rotate(back, boxes.slice(-1, 0, 3) - references.origin);
  std::vector<Tensor> columns;
  for (std::int64_t axis = 0; axis < 3; ++axis) {
    Tensor unit = at::zeros({1, 3}, boxes.options());
    unit[0][axis] = 1;
    columns.push_back(internal::rotate(turn, unit.expand({boxes.size(0), 3})) *
                      (0.5 * boxes.slice(-1, 3 + axis, 4 + axis)));
  }
  const Tensor half_axes = at::matmul(at::stack(columns, -1).unsqueeze(1),
                                      renamings().to(boxes.scalar_type()).unsqueeze(0));
  const Tensor corners =
      four_corners(center.unsqueeze(1).expand({boxes.size(0), 24, 3}), half_axes);
  return corners / largest_size(references).view({-1, 1, 1, 1});
}

Tensor box_of_corners(const Tensor& points, const References& references) {
  const References frame = references.detached(at::kDouble);
  const Tensor scaled =
      (points.detach().to(at::kDouble) * largest_size(frame).view({-1, 1, 1})).contiguous();
  const Tensor turn = frame.rotation.contiguous(), origin = frame.origin.contiguous();
  std::vector<geometry::Box> boxes;
  for (std::int64_t n = 0; n < scaled.size(0); ++n) {
    geometry::Box box = box_of(Eigen::Map<const Eigen::Matrix<double, 4, 3, Eigen::RowMajor>>(
        scaled.data_ptr<double>() + 12 * n));
    const double* q = turn.data_ptr<double>() + 4 * n;
    const geometry::Quaternion rotation(q[0], q[1], q[2], q[3]);
    box.center = rotation * box.center +
                 Eigen::Map<const Eigen::Vector3d>(origin.data_ptr<double>() + 3 * n);
    box.rotation = rotation * box.rotation;
    boxes.push_back(box);
  }
  return to_tensor(boxes);
}

FourPointHead::FourPointHead(FourPointOptions options, HeadContext context)
    : options_(std::move(options)), context_(std::move(context)) {
  validate_options(options_, "four_point head");
  layers_ = register_module(
      "layers", std::make_shared<MultilayerPerceptron>(context_.features + context_.condition,
                                                       options_.hidden, std::int64_t{12}));
}

Tensor FourPointHead::corners(const HeadInput& input) const {
  const Tensor raw = layers_->forward(input.joined()).view({-1, 4, 3});
  const Tensor own = at::diag_embed(0.5 * input.references.size);
  const Tensor start = four_corners(at::zeros_like(input.references.origin), own) /
                       largest_size(input.references).view({-1, 1, 1});
  return raw + start;
}

std::unique_ptr<BoxDistribution> FourPointHead::forward(const HeadInput& input) {
  input.require_valid(context_, "four_point head");
  return std::make_unique<PointDistribution>(box_of_corners(corners(input), input.references));
}

HeadLoss FourPointHead::loss(const HeadInput& input, const Tensor& target_boxes) {
  input.require_valid(context_, "four_point head");
  require_targets(target_boxes, input.count(), "four_point head");
  const Tensor targets =
      corner_assignments(target_boxes, input.references.detached(target_boxes.scalar_type()));
  const Tensor predicted = corners(input).unsqueeze(1);
  const Tensor each = point_loss(predicted - targets, options_.loss, options_.beta).mean({2, 3});
  const Tensor loss = each.amin(1);
  return {loss, {{"distance", loss}}};
}

}  // namespace arbox::heads
