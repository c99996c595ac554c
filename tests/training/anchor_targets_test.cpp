#include "arbox/training/pv_rcnn/anchor_targets.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/empty.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/geometry/overlap.h"
#include "training/tiny_network.h"

namespace arbox::training::pv_rcnn {
namespace {

using geometry::Box;

std::vector<std::int64_t> numbers(const at::Tensor& tensor) {
  const at::Tensor rows = tensor.contiguous();
  return {rows.data_ptr<std::int64_t>(), rows.data_ptr<std::int64_t>() + rows.numel()};
}

const std::vector<AnchorRule> kRules = {{0.6, 0.45}, {0.5, 0.35}};

struct Fixture {
  at::Tensor anchors = detectors::pv_rcnn::make_anchors(tiny_network());
  std::int64_t count = anchors.size(0);
  at::Tensor all = at::arange(count, at::kLong);
  AnchorAssigner assigner{anchors, kRules, 2, true};
};

/// The box with its heading rounded to a right angle, at height 0.
Box nearest(Box box) {
  const double turned = std::abs(std::remainder(geometry::yaw(box), std::numbers::pi));
  if (turned >= std::numbers::pi / 4) std::swap(box.size.x(), box.size.y());
  return geometry::make_yaw_box(box.center, box.size, 0);
}

std::vector<SceneObject> random_objects(std::uint64_t seed, int count) {
  const RandomStream random(seed, 0, 0);
  std::uint32_t draw = 0;
  const auto u = [&](double low, double high) { return random.uniform(draw++, low, high); };
  std::vector<SceneObject> objects;
  for (int i = 0; i < count; ++i) {
    SceneObject object;
    object.label = i % 2;
    const Eigen::Vector3d size = object.label == 0 ? Eigen::Vector3d(u(3, 5), u(1.4, 2), 1.5)
                                                   : Eigen::Vector3d(u(0.5, 1), u(0.5, 0.8), 1.7);
    object.box = geometry::make_yaw_box({u(-24, 24), u(-24, 24), -1}, size, u(-3.1, 3.1));
    if (i % 5 == 4) {
      object.label = kOtherObject;
      object.resembles = 0;
    }
    objects.push_back(object);
  }
  return objects;
}

/// The rule as it is told, anchor by anchor, with the library's exact overlap.
std::vector<std::int64_t> slow_kinds(const at::Tensor& anchors, std::vector<SceneObject> objects) {
  const auto count = static_cast<std::size_t>(anchors.size(0));
  std::vector<Box> boxes;
  for (std::size_t a = 0; a < count; ++a) {
    const at::Tensor row = anchors[static_cast<std::int64_t>(a)].to(at::kDouble).contiguous();
    const double* n = row.data_ptr<double>();
    boxes.push_back(nearest(geometry::make_yaw_box({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6])));
  }
  std::vector<std::int64_t> kinds(count, 0);
  std::vector<bool> forced(count, false);
  std::vector<double> best(count, 0), similar(count, 0);
  for (const SceneObject& object : objects) {
    const int label = object.label >= 0 ? object.label : object.resembles;
    std::vector<double> iou(count, 0);
    double highest = 0;
    for (std::size_t a = 0; a < count; ++a) {
      if (static_cast<int>(a / 2 % 2) != label) continue;
      iou[a] = geometry::overlap(boxes[a], nearest(object.box),
                                 {.measure = geometry::Overlap::kIou,
                                  .space = geometry::OverlapSpace::kBirdsEye,
                                  .threads = 1});
      highest = std::max(highest, iou[a]);
    }
    for (std::size_t a = 0; a < count; ++a) {
      double& target = object.label >= 0 ? best[a] : similar[a];
      target = std::max(target, iou[a]);
      if (object.label >= 0 && highest > 0 && iou[a] > highest - 1e-9) forced[a] = true;
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    const AnchorRule& rule = kRules[a / 2 % 2];
    if (forced[a] || best[a] >= rule.positive_iou) {
      kinds[a] = 1;
    } else if (best[a] >= rule.negative_iou || similar[a] >= rule.negative_iou) {
      kinds[a] = -1;
    }
  }
  return kinds;
}

TEST(AnchorTargets, AgreeWithTheRuleAnchorByAnchor) {
  const Fixture fixture;
  for (const std::uint64_t seed : {1u, 2u}) {
    const auto objects = random_objects(seed, 12);
    const AnchorTargets targets = fixture.assigner.assign(objects, fixture.all);
    EXPECT_EQ(numbers(targets.kind), slow_kinds(fixture.anchors, objects));
    const auto positives = numbers(targets.positives), matched = numbers(targets.objects);
    ASSERT_EQ(positives.size(), matched.size());
    EXPECT_GT(positives.size(), 9u);
    for (std::size_t i = 0; i < positives.size(); ++i) {
      EXPECT_EQ(objects[matched[i]].label, positives[i] / 2 % 2) << "class of anchor and object";
    }
  }
}

TEST(AnchorTargets, EveryObjectInRangeHasAnAnchor) {
  const Fixture fixture;
  for (std::uint64_t seed = 10; seed < 30; ++seed) {
    const auto objects = random_objects(seed, 1);
    EXPECT_GE(fixture.assigner.assign(objects, fixture.all).positives.numel(), 1) << seed;
  }
}

TEST(AnchorTargets, NoObjectsMakeEverythingNegative) {
  const Fixture fixture;
  const AnchorTargets targets = fixture.assigner.assign({}, fixture.all);
  EXPECT_EQ(targets.kind.abs().sum().item<std::int64_t>(), 0);
  EXPECT_EQ(targets.kind.numel(), fixture.count);
  EXPECT_EQ(targets.positives.numel(), 0);
  const at::Tensor none = at::empty({0}, at::kLong);
  EXPECT_EQ(fixture.assigner.assign(random_objects(1, 3), none).kind.numel(), 0);
}

TEST(AnchorTargets, OfSomeCandidatesTheBestOneIsForced) {
  const Fixture fixture;
  SceneObject car;
  car.box = geometry::make_yaw_box({3.3, 4.4, -1}, {4, 1.7, 1.5}, 0.2);
  const auto all = fixture.assigner.assign(std::vector{car}, fixture.all);
  const auto positives = numbers(all.positives);
  // Without the anchors that were positive, the next best stands in.
  std::vector<std::int64_t> left;
  for (std::int64_t a = 0; a < fixture.count; ++a) {
    if (std::find(positives.begin(), positives.end(), a) == positives.end()) left.push_back(a);
  }
  at::Tensor candidates = at::empty({static_cast<std::int64_t>(left.size())}, at::kLong);
  std::copy(left.begin(), left.end(), candidates.data_ptr<std::int64_t>());
  const auto rest = fixture.assigner.assign(std::vector{car}, candidates);
  ASSERT_GE(rest.positives.numel(), 1);
  EXPECT_EQ(rest.kind.numel(), candidates.numel());
}

TEST(AnchorTargets, VansAreBackgroundIfAsked) {
  const Fixture fixture;
  SceneObject van;
  van.box = geometry::make_yaw_box({3.2, 3.2, -1}, {4, 1.7, 1.5}, 0);
  van.label = kOtherObject;
  van.resembles = 0;
  const AnchorAssigner strict(fixture.anchors, kRules, 2, false);
  EXPECT_EQ(strict.assign(std::vector{van}, fixture.all).kind.abs().sum().item<std::int64_t>(), 0);
  const auto lenient = fixture.assigner.assign(std::vector{van}, fixture.all);
  EXPECT_LT(lenient.kind.min().item<std::int64_t>(), 0);
  EXPECT_EQ(lenient.positives.numel(), 0);
  van.resembles = -1;
  EXPECT_EQ(
      fixture.assigner.assign(std::vector{van}, fixture.all).kind.abs().sum().item<std::int64_t>(),
      0);
}

TEST(AnchorTargets, RefusesWhatDoesNotFit) {
  const Fixture fixture;
  EXPECT_THROW(AnchorAssigner(fixture.anchors.slice(1, 0, 6), kRules, 2, true), InvalidArgument);
  EXPECT_THROW(AnchorAssigner(fixture.anchors.slice(0, 0, 7), kRules, 2, true), InvalidArgument);
  EXPECT_THROW(AnchorAssigner(fixture.anchors, {}, 2, true), InvalidArgument);
  auto objects = random_objects(1, 1);
  objects[0].label = 2;
  EXPECT_THROW(fixture.assigner.assign(objects, fixture.all), InvalidArgument);
  EXPECT_THROW(fixture.assigner.assign({}, fixture.all + 1), InvalidArgument);
}

}  // namespace
}  // namespace arbox::training::pv_rcnn
