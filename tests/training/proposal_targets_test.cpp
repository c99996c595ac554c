#include "arbox/training/pv_rcnn/proposal_targets.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <set>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/geometry/overlap.h"
#include "arbox/heads/rotated_iou.h"
#include "arbox/heads/yaw_codecs.h"
#include "arbox/training/internal/tensors.h"
#include "training/made_scene.h"

namespace arbox::training::pv_rcnn {
namespace {

using detectors::pv_rcnn::Proposals;

/// Proposals near the objects of each scan, from exact to far away, of their class.
Proposals near_objects(const SceneObjects& objects, int count, double spread) {
  const RandomStream random(5, 0, 0);
  std::uint32_t draw = 0;
  std::vector<SceneObject> boxes;
  std::vector<std::int64_t> labels, scenes;
  for (std::size_t scan = 0; scan < objects.size(); ++scan) {
    for (int i = 0; i < count && !objects[scan].empty(); ++i) {
      SceneObject object = objects[scan][i % objects[scan].size()];
      const double off = spread * i / count;
      object.box.center.x() += random.uniform(draw++, -off, off);
      object.box.center.y() += random.uniform(draw++, -off, off);
      labels.push_back(std::max(object.label, 0));
      scenes.push_back(static_cast<std::int64_t>(scan));
      boxes.push_back(object);
    }
  }
  Proposals result;
  result.boxes = internal::to_rows(boxes);
  result.labels = internal::to_tensor(labels);
  result.scene = internal::to_tensor(scenes);
  result.scores = at::zeros({result.labels.numel()});
  return result;
}

SceneObjects two_scans() { return {made_scene(1).objects, made_scene(2).objects}; }

std::int64_t count_of(const at::Tensor& mask) { return mask.sum().item<std::int64_t>(); }

TEST(ProposalTargets, RatiosAndTargetsAreAsAsked) {
  const SceneObjects objects = two_scans();
  const Proposals proposals = near_objects(objects, 400, 2.0);
  const ProposalTargetOptions options;
  const ProposalTargets drawn = draw_proposals(proposals, objects, options, false, 1, 0);
  ASSERT_EQ(drawn.boxes.size(0), 256);
  for (std::int64_t scan = 0; scan < 2; ++scan) {
    const at::Tensor here = drawn.scene == scan;
    EXPECT_EQ(count_of(here), 128);
    EXPECT_EQ(count_of(here.logical_and(drawn.iou >= 0.55)), 64);
    EXPECT_EQ(count_of(here.logical_and(drawn.iou >= 0.1).logical_and(drawn.iou < 0.55)), 51);
    EXPECT_EQ(count_of(here.logical_and(drawn.iou < 0.1)), 13);
  }
  EXPECT_TRUE(((drawn.iou >= 0.55).nonzero().squeeze(1) == drawn.foreground).all().item<bool>());
  const at::Tensor line = ((drawn.iou - 0.25) / 0.5).clamp(0, 1);
  EXPECT_TRUE(drawn.confidence.allclose(line));
}

TEST(ProposalTargets, IousAreThoseWithTheBestObjectOfTheClass) {
  const SceneObjects objects = two_scans();
  const ProposalTargets drawn =
      draw_proposals(near_objects(objects, 100, 4.0), objects, {}, false, 2, 0);
  const auto boxes = internal::to_boxes(drawn.boxes);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const auto row = static_cast<std::int64_t>(i);
    double best = 0;
    for (const SceneObject& object : objects[drawn.scene[row].item<std::int64_t>()]) {
      if (object.label != drawn.labels[row].item<std::int64_t>()) continue;
      best = std::max(best, geometry::overlap(boxes[i], object.box));
    }
    EXPECT_NEAR(drawn.iou[row].item<double>(), best, 1e-5);
  }
  const at::Tensor regions = drawn.boxes.index_select(0, drawn.foreground);
  EXPECT_TRUE(heads::rotated_iou(regions, drawn.objects)
                  .allclose(drawn.iou.index_select(0, drawn.foreground), 1e-4, 1e-4));
}

TEST(ProposalTargets, ForegroundIsDrawnOnceAndDrawsDependOnSeedAndScene) {
  const SceneObjects objects = two_scans();
  const Proposals proposals = near_objects(objects, 400, 2.0);
  const auto rows = [&](std::uint64_t seed, std::int64_t first) {
    return draw_proposals(proposals, objects, {}, false, seed, first).boxes;
  };
  EXPECT_TRUE(rows(1, 4).equal(rows(1, 4)));
  EXPECT_FALSE(rows(1, 4).equal(rows(2, 4)));
  EXPECT_FALSE(rows(1, 4).equal(rows(1, 5)));
  const ProposalTargets drawn = draw_proposals(proposals, objects, {}, false, 1, 4);
  std::set<std::pair<float, float>> places;
  const at::Tensor foreground = drawn.boxes.index_select(0, drawn.foreground);
  for (std::int64_t i = 0; i < foreground.size(0); ++i) {
    EXPECT_TRUE(
        places.emplace(foreground[i][0].item<float>(), foreground[i][1].item<float>()).second);
  }
  // A process that has the second scan alone draws the same.
  Proposals second = proposals;
  const at::Tensor index = (proposals.scene == 1).nonzero().squeeze(1);
  second.boxes = proposals.boxes.index_select(0, index);
  second.labels = proposals.labels.index_select(0, index);
  second.scene = at::zeros({index.numel()}, at::kLong);
  EXPECT_TRUE(
      draw_proposals(second, {objects[1]}, {}, false, 1, 5).boxes.equal(drawn.boxes.slice(0, 128)));
}

TEST(ProposalTargets, OneKindAloneFillsTheCountAndNothingGivesNothing) {
  SceneObjects objects = two_scans();
  const auto all = [&](double spread) {
    return draw_proposals(near_objects(objects, 40, spread), objects, {}, false, 1, 0);
  };
  EXPECT_EQ(all(0.0).boxes.size(0), 256);
  objects[0].pop_back();
  objects[1].pop_back();
  EXPECT_EQ(all(0.0).foreground.numel(), 256);
  SceneObjects none = {{}, {}};
  const ProposalTargets background =
      draw_proposals(near_objects(objects, 40, 3.0), none, {}, false, 1, 0);
  EXPECT_EQ(background.boxes.size(0), 256);
  EXPECT_EQ(background.foreground.numel(), 0);
  EXPECT_EQ(background.objects.size(1), 7);
  EXPECT_EQ(background.confidence.abs().sum().item<double>(), 0);
  const ProposalTargets nothing =
      draw_proposals(near_objects(none, 40, 3.0), none, {}, false, 1, 0);
  EXPECT_EQ(nothing.boxes.sizes(), (std::vector<std::int64_t>{0, 7}));
  EXPECT_EQ(nothing.objects.sizes(), (std::vector<std::int64_t>{0, 7}));
}

TEST(ProposalTargets, AVanIsNeitherCarNorBackgroundIfAsked) {
  SceneObjects objects = {{made_scene(1).objects[3]}};
  Proposals proposals = near_objects(objects, 10, 0.0);
  proposals.labels.fill_(0);
  const auto confidence = [&](bool ignore) {
    return draw_proposals(proposals, objects, {}, ignore, 1, 0).confidence;
  };
  EXPECT_TRUE((confidence(true) == -1).all().item<bool>());
  EXPECT_TRUE((confidence(false) == 0).all().item<bool>());
}

TEST(ProposalTargets, RefusesWhatDoesNotFit) {
  const SceneObjects objects = two_scans();
  const Proposals proposals = near_objects(objects, 10, 1.0);
  ProposalTargetOptions options;
  options.confidence_low = 0.8;
  EXPECT_THROW(draw_proposals(proposals, objects, options, false, 1, 0), ConfigError);
  EXPECT_THROW(draw_proposals(proposals, {objects[0]}, {}, false, 1, 0), InvalidArgument);
  Proposals broken = proposals;
  broken.boxes = proposals.boxes.clone();
  broken.boxes[3][0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(draw_proposals(broken, objects, {}, false, 1, 0), NumericalError);
}

TEST(ProposalTargets, AlignedBoxesAreTheSameBoxesInTheRegionsDirection) {
  const SceneObjects objects = two_scans();
  const at::Tensor boxes = internal::to_rows(objects[0], at::kDouble);
  for (const double turn : {0.0, 0.4, 1.5, 1.7, 3.1, -2.0, 5.9}) {
    at::Tensor regions = boxes.clone();
    regions.select(1, 6) += turn;
    const at::Tensor aligned = aligned_boxes(boxes, regions);
    EXPECT_TRUE(heads::rotated_iou(aligned, boxes).allclose(at::full({4}, 1.0, at::kDouble)));
    const at::Tensor residuals = detectors::pv_rcnn::encode_region_residuals(aligned, regions);
    EXPECT_LE(residuals.select(1, 6).abs().max().item<double>(), std::numbers::pi / 2 + 1e-9);
    // The codec of the heads sees the same numbers.
    const heads::ResidualCodec codec([] {
      auto options = heads::ResidualCodec::defaults();
      options.order = "center_size_rotation";
      return options;
    }());
    const at::Tensor rows = detectors::pv_rcnn::to_box_rows(regions);
    const heads::References references{rows.slice(1, 0, 3), rows.slice(1, 6, 10),
                                       rows.slice(1, 3, 6)};
    EXPECT_TRUE(codec.encode(detectors::pv_rcnn::to_box_rows(boxes), references)
                    .allclose(residuals, 1e-9, 1e-9))
        << turn;
  }
}

TEST(KeypointTargets, InsideRingAndOutside) {
  SceneObject car;
  car.box = geometry::make_yaw_box({5, 5, 0}, {4, 2, 1.5}, 0);
  SceneObject van = car;
  van.box.center.x() = 15;
  van.label = kOtherObject;
  van.resembles = 0;
  at::Tensor points = at::zeros({6, 3});
  const float x[] = {5.0f, 6.95f, 7.05f, 7.15f, 15.0f, 5.0f};
  for (int i = 0; i < 6; ++i) {
    points[i][0] = x[i];
    points[i][1] = 5;
  }
  const SceneObjects objects = {{car, van}, {}};
  const std::vector<std::int64_t> counts = {5, 1};
  const auto targets = [&](bool ignore) {
    const at::Tensor result = keypoint_targets(points, counts, objects, 0.2, ignore);
    return std::vector<float>(result.data_ptr<float>(), result.data_ptr<float>() + 6);
  };
  EXPECT_THAT(targets(false), ::testing::ElementsAre(1, 1, -1, 0, 0, 0));
  EXPECT_THAT(targets(true), ::testing::ElementsAre(1, 1, -1, 0, -1, 0));
  EXPECT_EQ(keypoint_targets(at::zeros({0, 3}), std::vector<std::int64_t>{0, 0}, objects, 0.2, true)
                .numel(),
            0);
}

}  // namespace
}  // namespace arbox::training::pv_rcnn
