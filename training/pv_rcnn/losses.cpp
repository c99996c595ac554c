#include "arbox/training/pv_rcnn/losses.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/abs.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/binary_cross_entropy_with_logits.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/cross_entropy_loss.h>
#include <ATen/ops/minimum.h>
#include <ATen/ops/pow.h>
#include <ATen/ops/sigmoid.h>
#include <ATen/ops/sin.h>
#include <ATen/ops/where.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <numbers>
#include <vector>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/heads/point_loss.h"
#include "arbox/sparse/point_sets.h"
#include "arbox/training/internal/tensors.h"

namespace arbox::training::pv_rcnn {

using at::Tensor;
using namespace detectors::pv_rcnn;

namespace {

Tensor cross_entropy_of(const Tensor& logits, const Tensor& targets) {
  return at::binary_cross_entropy_with_logits(logits, targets, {}, {}, at::Reduction::None);
}

Tensor corners(const Tensor& boxes) {
  // Two cells an edge have their centres at a quarter of it: those of twice the box are its
  // corners.
  return sparse::roi_grid_points(
      to_box_rows(
          at::cat({boxes.slice(1, 0, 3), 2 * boxes.slice(1, 3, 6), boxes.slice(1, 6, 7)}, 1)),
      2);
}

Tensor turned_by_half(const Tensor& boxes) {
  return at::cat({boxes.slice(1, 0, 6), boxes.slice(1, 6, 7) + std::numbers::pi}, 1);
}

/// The targets of all scans in the rows of the network's output.
struct JoinedTargets {
  Tensor weight;     // (N) 0 for ignored candidates, 1 / positives of the scan for others
  Tensor positives;  // (P) rows
  Tensor boxes;      // (P, 7)
  Tensor labels;     // (P)
  Tensor share;      // (P) 1 / positives of the scan
};

JoinedTargets join(std::span<const AnchorTargets> targets, const SceneObjects& objects,
                   at::ScalarType type) {
  std::vector<Tensor> weights, positives, boxes, labels, shares;
  std::int64_t start = 0;
  for (std::size_t scan = 0; scan < targets.size(); ++scan) {
    const AnchorTargets& target = targets[scan];
    const std::int64_t count = target.positives.numel();
    const double share = 1.0 / static_cast<double>(std::max<std::int64_t>(count, 1));
    weights.push_back((target.kind >= 0).to(type) * share);
    positives.push_back(target.positives + start);
    boxes.push_back(internal::to_rows(objects[scan], type).index_select(0, target.objects));
    std::vector<std::int64_t> classes;
    for (const SceneObject& object : objects[scan]) classes.push_back(object.label);
    labels.push_back(internal::to_tensor(classes).index_select(0, target.objects));
    shares.push_back(at::zeros({count}, type) + share);
    start += target.kind.numel();
  }
  return {at::cat(weights), at::cat(positives), at::cat(boxes), at::cat(labels), at::cat(shares)};
}

}  // namespace

Tensor focal_loss(const Tensor& logits, const Tensor& targets, const LossOptions& options) {
  const Tensor probability = at::sigmoid(logits);
  const Tensor miss = targets + probability - 2 * targets * probability;
  const Tensor weight = (1 - options.focal_alpha) + (2 * options.focal_alpha - 1) * targets;
  return weight * at::pow(miss, options.focal_gamma) * cross_entropy_of(logits, targets);
}

Tensor anchor_box_loss(const Tensor& residuals, const Tensor& targets, double beta) {
  const Tensor difference = at::cat({residuals.slice(1, 0, 6) - targets.slice(1, 0, 6),
                                     at::sin(residuals.slice(1, 6, 7) - targets.slice(1, 6, 7))},
                                    1);
  return heads::point_loss(difference, heads::PointLoss::kSmoothL1, beta);
}

Tensor corner_loss(const Tensor& boxes, const Tensor& targets) {
  const Tensor found = corners(boxes);
  const auto distance = [&](const Tensor& sought) {
    return (found - corners(sought)).norm(2, {-1}, false);
  };
  const Tensor nearest = at::minimum(distance(targets), distance(turned_by_half(targets)));
  return heads::point_loss(nearest, heads::PointLoss::kSmoothL1, 1.0).mean(-1);
}

LossSums first_stage_losses(const FirstStage& first, const Tensor& anchors,
                            std::span<const AnchorTargets> targets, const SceneObjects& objects,
                            double direction_offset, const LossOptions& options) {
  const at::ScalarType type = first.scores.scalar_type();
  const JoinedTargets joined = join(targets, objects, type);
  const Tensor classes = at::arange(first.scores.size(1), at::kLong);
  Tensor sought = at::zeros(first.scores.sizes(), type);
  sought.index_put_({joined.positives}, (joined.labels.unsqueeze(1) == classes).to(type));

  const Tensor residuals = first.residuals.index_select(0, joined.positives);
  const Tensor used =
      anchors.index_select(0, first.anchors.index_select(0, joined.positives)).to(type);
  const Tensor directions = first.directions.index_select(0, joined.positives);
  const Tensor direction_each =
      at::cross_entropy_loss(directions, direction_of(joined.boxes.select(1, 6), direction_offset),
                             {}, at::Reduction::None);
  return {
      {"classification",
       (focal_loss(first.scores, sought, options) * joined.weight.unsqueeze(1)).sum()},
      {"box", (anchor_box_loss(residuals, encode_residuals(joined.boxes, used), options.beta) *
               joined.share.unsqueeze(1))
                  .sum()},
      {"direction", (direction_each * joined.share).sum()},
  };
}

LossSums second_stage_losses(const SecondStage& second, const ProposalTargets& targets,
                             const LossOptions& options) {
  const at::ScalarType type = second.confidence.scalar_type();
  const Tensor confidence = targets.confidence.to(type);
  const Tensor counted = (confidence >= 0).to(type);
  const Tensor regions = targets.boxes.index_select(0, targets.foreground).to(type);
  const Tensor residuals = second.residuals.index_select(0, targets.foreground);
  const Tensor objects = targets.objects.to(type);
  const Tensor sought = encode_region_residuals(aligned_boxes(objects, regions), regions);
  const Tensor residual =
      heads::point_loss(residuals - sought, heads::PointLoss::kSmoothL1, options.beta);
  return {
      {"confidence", (cross_entropy_of(second.confidence, confidence.clamp(0, 1)) * counted).sum()},
      {"residual", residual.sum()},
      {"corner", corner_loss(decode_region_residuals(residuals, regions), objects).sum()},
  };
}

Tensor keypoint_loss(const Tensor& logits, const Tensor& targets, const LossOptions& options) {
  const Tensor sought = targets.to(logits.scalar_type());
  const Tensor counted = (sought >= 0).to(logits.scalar_type());
  return (focal_loss(logits, sought.clamp(0, 1), options) * counted).sum();
}

}  // namespace arbox::training::pv_rcnn
