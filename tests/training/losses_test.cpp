#include "arbox/training/pv_rcnn/losses.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/full.h>
#include <ATen/ops/rand.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/geometry/box.h"
#include "arbox/training/internal/tensors.h"
#include "sparse/gradient_check.h"
#include "training/made_scene.h"
#include "training/tiny_network.h"

namespace arbox::training::pv_rcnn {
namespace {

using at::Tensor;
using detectors::pv_rcnn::FirstStage;
using detectors::pv_rcnn::SecondStage;
using sparse::expect_gradients;

Tensor doubles(std::vector<std::int64_t> shape) { return at::randn(shape, at::kDouble); }

/// (N, 7) boxes near one another, of ordinary sizes.
Tensor random_boxes(std::int64_t count) {
  const auto options = at::TensorOptions().dtype(at::kDouble);
  return at::cat({at::randn({count, 3}, options), at::rand({count, 3}, options) + 1,
                  6 * at::rand({count, 1}, options) - 3},
                 1);
}

TEST(Losses, FocalLossIsTheFormulaAndStaysFiniteFarOut) {
  const LossOptions options;
  for (const double logit : {-3.0, -0.2, 0.0, 1.7}) {
    for (const double target : {0.0, 1.0}) {
      const double p = 1 / (1 + std::exp(-logit));
      const double expected =
          target > 0 ? -0.25 * (1 - p) * (1 - p) * std::log(p) : -0.75 * p * p * std::log(1 - p);
      EXPECT_NEAR(
          focal_loss(at::full({1}, logit, at::kDouble), at::full({1}, target, at::kDouble), options)
              .item<double>(),
          expected, 1e-12);
    }
  }
  const Tensor far = at::full({1}, 500.0f);
  EXPECT_EQ(focal_loss(far, at::full({1}, 1.0f), options).item<float>(), 0.0f);
  EXPECT_NEAR(focal_loss(-far, at::full({1}, 1.0f), options).item<float>(), 125.0f, 1e-3f);
}

TEST(Losses, FocalLossGradient) {
  const Tensor targets = (at::rand({6, 3}, at::kDouble) > 0.5).to(at::kDouble);
  expect_gradients({2 * doubles({6, 3})},
                   [&](const std::vector<Tensor>& in) { return focal_loss(in[0], targets, {}); });
}

TEST(Losses, AnchorBoxLossTakesHeadingsUpToHalfATurn) {
  const Tensor targets = doubles({5, 7});
  Tensor turned = targets.clone();
  turned.select(1, 6) += std::numbers::pi;
  EXPECT_LT(anchor_box_loss(turned, targets, 1.0 / 9).abs().max().item<double>(), 1e-20);
  Tensor off = targets.clone();
  off.select(1, 0) += 0.05;
  off.select(1, 1) += 2.0;
  const Tensor loss = anchor_box_loss(off, targets, 1.0 / 9);
  EXPECT_NEAR(loss[0][0].item<double>(), 4.5 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(loss[0][1].item<double>(), 2.0 - 0.5 / 9, 1e-12);
  EXPECT_EQ(loss[0][2].item<double>(), 0.0);
  expect_gradients({doubles({5, 7})}, [&](const std::vector<Tensor>& in) {
    return anchor_box_loss(in[0], targets, 1.0 / 9);
  });
}

TEST(Losses, CornerLossIsTheMeanHuberDistanceOfTheCorners) {
  const Tensor targets = random_boxes(6), boxes = random_boxes(6);
  const auto found = internal::to_boxes(boxes), sought = internal::to_boxes(targets);
  const Tensor loss = corner_loss(boxes, targets);
  for (std::size_t i = 0; i < found.size(); ++i) {
    geometry::Box turned = sought[i];
    turned.rotation =
        geometry::make_yaw_box(turned.center, turned.size, geometry::yaw(turned) + std::numbers::pi)
            .rotation;
    const auto here = geometry::corners(found[i]);
    const auto there = geometry::corners(sought[i]), back = geometry::corners(turned);
    double sum = 0;
    for (int k = 0; k < 8; ++k) {
      const double d = std::min((here[k] - there[k]).norm(), (here[k] - back[k]).norm());
      sum += d < 1 ? 0.5 * d * d : d - 0.5;
    }
    EXPECT_NEAR(loss[static_cast<std::int64_t>(i)].item<double>(), sum / 8, 1e-9);
  }
  EXPECT_LT(corner_loss(targets, targets).max().item<double>(), 1e-20);
  expect_gradients({boxes},
                   [&](const std::vector<Tensor>& in) { return corner_loss(in[0], targets); });
  EXPECT_EQ(corner_loss(random_boxes(0), random_boxes(0)).numel(), 0);
  // Coincident corners have a gradient too.
  Tensor same = targets.clone().set_requires_grad(true);
  corner_loss(same, targets).sum().backward();
  EXPECT_TRUE(same.grad().isfinite().all().item<bool>());
}

struct FirstFixture {
  Tensor anchors = detectors::pv_rcnn::make_anchors(tiny_network());
  std::int64_t count = anchors.size(0);
  SceneObjects objects = {made_scene(1).objects, {}};
  std::vector<AnchorTargets> targets;
  FirstStage first;

  FirstFixture() {
    const AnchorAssigner assigner(anchors, {{0.6, 0.45}, {0.5, 0.35}}, 2, true);
    const Tensor all = at::arange(count, at::kLong);
    // Few candidates keep differences quick: those that are not plainly negative, and some others.
    const AnchorTargets whole = assigner.assign(objects[0], all);
    const Tensor few = at::cat({(whole.kind != 0).nonzero().squeeze(1), all.slice(0, 0, 20)});
    first.anchors = at::cat({few, all.slice(0, 0, 12)});
    first.counts = {few.numel(), 12};
    targets = {assigner.assign(objects[0], few), assigner.assign({}, all.slice(0, 0, 12))};
    first.scores = doubles({first.anchors.numel(), 2});
    first.residuals = 0.3 * doubles({first.anchors.numel(), 7});
    first.directions = doubles({first.anchors.numel(), 2});
  }
  LossSums losses() const {
    return first_stage_losses(first, anchors, targets, objects, 0.78539, {});
  }
};

TEST(FirstStageLosses, AreSumsOverScansDividedByTheirPositives) {
  FirstFixture fixture;
  const LossSums sums = fixture.losses();
  const std::int64_t first = fixture.first.counts[0];
  const AnchorTargets& target = fixture.targets[0];
  const auto positives = static_cast<double>(target.positives.numel());
  ASSERT_GT(positives, 2);
  double classes = 0, boxes = 0, directions = 0;
  const LossOptions options;
  const Tensor rows = internal::to_rows(fixture.objects[0], at::kDouble);
  for (std::int64_t i = 0; i < fixture.first.anchors.numel(); ++i) {
    const bool in_first = i < first;
    const std::int64_t kind = in_first ? target.kind[i].item<std::int64_t>()
                                       : fixture.targets[1].kind[i - first].item<std::int64_t>();
    if (kind < 0) continue;
    const std::int64_t anchor = fixture.first.anchors[i].item<std::int64_t>();
    Tensor sought = at::zeros({2}, at::kDouble);
    if (kind > 0) sought[anchor / 2 % 2] = 1;
    classes += focal_loss(fixture.first.scores[i], sought, options).sum().item<double>() /
               (in_first ? positives : 1.0);
    if (kind <= 0) continue;
    const Tensor where = (target.positives == i).nonzero();
    const Tensor box = rows[target.objects[where.item<std::int64_t>()].item<std::int64_t>()];
    const Tensor residual = detectors::pv_rcnn::encode_residuals(
        box.unsqueeze(0), fixture.anchors[anchor].unsqueeze(0).to(at::kDouble));
    boxes += anchor_box_loss(fixture.first.residuals[i].unsqueeze(0), residual, options.beta)
                 .sum()
                 .item<double>() /
             positives;
    const std::int64_t direction =
        detectors::pv_rcnn::direction_of(box.slice(0, 6, 7), 0.78539).item<std::int64_t>();
    directions -= fixture.first.directions[i].log_softmax(0)[direction].item<double>() / positives;
  }
  EXPECT_NEAR(sums.at("classification").item<double>(), classes, 1e-9);
  EXPECT_NEAR(sums.at("box").item<double>(), boxes, 1e-9);
  EXPECT_NEAR(sums.at("direction").item<double>(), directions, 1e-9);
}

TEST(FirstStageLosses, GradientsAreThoseOfCentralDifferences) {
  FirstFixture fixture;
  expect_gradients(
      {fixture.first.scores, fixture.first.residuals, fixture.first.directions},
      [&](const std::vector<Tensor>& in) {
        fixture.first.scores = in[0];
        fixture.first.residuals = in[1];
        fixture.first.directions = in[2];
        const LossSums sums = fixture.losses();
        return at::stack({sums.at("classification"), sums.at("box"), sums.at("direction")});
      });
}

TEST(FirstStageLosses, ScansWithoutObjectsOrCandidatesGiveNumbers) {
  FirstFixture fixture;
  fixture.objects = {{}, {}};
  const AnchorAssigner assigner(fixture.anchors, {{0.6, 0.45}, {0.5, 0.35}}, 2, true);
  const Tensor none = at::zeros({0}, at::kLong);
  fixture.first.anchors = fixture.first.anchors.slice(0, 0, 12);
  fixture.first.counts = {12, 0};
  fixture.targets = {assigner.assign({}, fixture.first.anchors), assigner.assign({}, none)};
  fixture.first.scores = doubles({12, 2}).set_requires_grad(true);
  fixture.first.residuals = doubles({12, 7}).set_requires_grad(true);
  fixture.first.directions = doubles({12, 2}).set_requires_grad(true);
  const LossSums sums = fixture.losses();
  EXPECT_GT(sums.at("classification").item<double>(), 0);
  EXPECT_EQ(sums.at("box").item<double>(), 0);
  (sums.at("classification") + sums.at("box") + sums.at("direction")).backward();
  EXPECT_EQ(fixture.first.residuals.grad().abs().sum().item<double>(), 0);
}

ProposalTargets made_targets(std::int64_t count, std::int64_t foreground) {
  ProposalTargets targets;
  targets.boxes = random_boxes(count);
  targets.labels = at::zeros({count}, at::kLong);
  targets.scene = at::zeros({count}, at::kLong);
  targets.iou = at::rand({count}, at::kDouble);
  targets.confidence = targets.iou.clone();
  if (count > 1) targets.confidence[1] = -1;
  targets.foreground = at::arange(foreground, at::kLong) * 2;
  targets.objects =
      targets.boxes.index_select(0, targets.foreground) + 0.1 * doubles({foreground, 7}).abs();
  return targets;
}

TEST(SecondStageLosses, AreZeroAtTheTargetsAndIgnoreWhatIsIgnored) {
  const ProposalTargets targets = made_targets(8, 3);
  const Tensor regions = targets.boxes.index_select(0, targets.foreground);
  SecondStage second;
  second.confidence = doubles({8});
  second.residuals = doubles({8, 7});
  second.residuals.index_copy_(0, targets.foreground,
                               detectors::pv_rcnn::encode_region_residuals(
                                   aligned_boxes(targets.objects, regions), regions));
  LossSums sums = second_stage_losses(second, targets, {});
  EXPECT_LT(sums.at("residual").item<double>(), 1e-12);
  EXPECT_LT(sums.at("corner").item<double>(), 1e-12);
  double expected = 0;
  for (std::int64_t i = 0; i < 8; ++i) {
    if (i == 1) continue;
    const double p = second.confidence[i].sigmoid().item<double>();
    const double y = targets.confidence[i].item<double>();
    expected -= y * std::log(p) + (1 - y) * std::log(1 - p);
  }
  EXPECT_NEAR(sums.at("confidence").item<double>(), expected, 1e-9);
}

TEST(SecondStageLosses, GradientsAreThoseOfCentralDifferences) {
  const ProposalTargets targets = made_targets(6, 3);
  expect_gradients({doubles({6}), 0.3 * doubles({6, 7})}, [&](const std::vector<Tensor>& in) {
    SecondStage second;
    second.confidence = in[0];
    second.residuals = in[1];
    const LossSums sums = second_stage_losses(second, targets, {});
    return at::stack({sums.at("confidence"), sums.at("residual"), sums.at("corner")});
  });
}

TEST(SecondStageLosses, NoProposalsAndNoForegroundGiveZeroWithAGraph) {
  for (const std::int64_t count : {0, 4}) {
    SecondStage second;
    second.confidence = doubles({count}).set_requires_grad(true);
    second.residuals = doubles({count, 7}).set_requires_grad(true);
    const LossSums sums = second_stage_losses(second, made_targets(count, 0), {});
    EXPECT_EQ(sums.at("residual").item<double>(), 0);
    EXPECT_EQ(sums.at("corner").item<double>(), 0);
    (sums.at("confidence") + sums.at("residual") + sums.at("corner")).backward();
    EXPECT_TRUE(second.residuals.grad().defined());
  }
}

TEST(KeypointLoss, LeavesOutIgnoredKeypoints) {
  Tensor logits = doubles({6});
  Tensor targets = at::zeros({6});
  targets[0] = 1;
  targets[1] = -1;
  const double before = keypoint_loss(logits, targets, {}).item<double>();
  logits[1] = 50;
  EXPECT_EQ(keypoint_loss(logits, targets, {}).item<double>(), before);
  expect_gradients(
      {logits}, [&](const std::vector<Tensor>& in) { return keypoint_loss(in[0], targets, {}); });
  EXPECT_EQ(keypoint_loss(doubles({0}), at::zeros({0}), {}).item<double>(), 0);
}

}  // namespace
}  // namespace arbox::training::pv_rcnn
