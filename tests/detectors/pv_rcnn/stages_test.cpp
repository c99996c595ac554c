#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <numeric>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/birds_eye_backbone.h"
#include "arbox/detectors/pv_rcnn/internal/keypoint_features.h"
#include "arbox/geometry/overlap.h"
#include "arbox/sparse/voxel_sets.h"
#include "detectors/pv_rcnn/small_network.h"

namespace arbox::detectors::pv_rcnn {
namespace {

PointBatch batch_of(const std::vector<std::vector<float>>& scans, const Options& options) {
  std::vector<geometry::PointCloudView> views;
  for (const auto& scan : scans) views.push_back(view_of(scan));
  return make_batch(views, options, false, 0);
}

/// All that comes out of the network for a batch, regions as proposed.
struct Outputs {
  FirstStage first;
  Proposals proposals;
  Keypoints keypoints;
  SecondStage second;
};

Outputs run(Network& network, const PointBatch& batch) {
  Outputs all;
  all.first = network.first_stage(batch);
  all.proposals = network.propose(all.first, network.options().proposals);
  all.keypoints = network.keypoints(batch, all.first, all.proposals.boxes, all.proposals.scene);
  all.second = network.second_stage(all.keypoints, all.proposals.boxes, all.proposals.scene);
  return all;
}

class PvRcnnStages : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(DenseAndSparse, PvRcnnStages, testing::Bool(),
                         [](const auto& test) { return test.param ? "sparse" : "dense"; });

TEST_P(PvRcnnStages, FoldedNormsGiveTheSame) {
  Network network(small_options(GetParam()));
  unsettle(network);
  network.eval();
  const PointBatch batch = batch_of({made_scan(1), made_scan(2)}, network.options());
  const FirstStage plain = network.first_stage(batch);
  const at::NoGradGuard no_gradient;
  const Outputs folded = run(network, batch);
  EXPECT_EQ(folded.first.counts, plain.counts);
  EXPECT_LT(largest_difference(folded.first.scores, plain.scores), 1e-3);
  EXPECT_LT(largest_difference(folded.first.residuals, plain.residuals), 1e-3);
  EXPECT_LT(largest_difference(folded.first.directions, plain.directions), 1e-3);
  at::AutoGradMode with_gradient(true);
  const auto& regions = folded.proposals;
  const Keypoints keypoints = network.keypoints(batch, folded.first, regions.boxes, regions.scene);
  const SecondStage second = network.second_stage(keypoints, regions.boxes, regions.scene);
  EXPECT_LT(largest_difference(second.features, folded.second.features), 1e-3);
  EXPECT_LT(largest_difference(second.residuals, folded.second.residuals), 1e-3);
  EXPECT_LT(largest_difference(second.confidence, folded.second.confidence), 1e-3);
}

TEST_P(PvRcnnStages, PackedWeightsFollowTheParameters) {
  Network network(small_options(GetParam()));
  network.eval();
  const PointBatch batch = batch_of({made_scan(1)}, network.options());
  const at::NoGradGuard no_gradient;
  const at::Tensor before = network.first_stage(batch).scores;
  unsettle(network);
  const at::Tensor after = network.first_stage(batch).scores;
  EXPECT_GT(largest_difference(before, after), 1e-3);
}

TEST_P(PvRcnnStages, AScanDoesNotDependOnItsBatch) {
  Network network(small_options(GetParam()));
  unsettle(network);
  network.eval();
  const at::NoGradGuard no_gradient;
  const Outputs both = run(network, batch_of({made_scan(1), made_scan(2)}, network.options()));
  const Outputs alone = run(network, batch_of({made_scan(2)}, network.options()));
  const std::int64_t rows = both.first.counts[0];
  EXPECT_LT(largest_difference(both.first.scores.slice(0, rows), alone.first.scores), 1e-4);
  const at::Tensor second = (both.proposals.scene == 1).nonzero().squeeze(1);
  ASSERT_EQ(second.size(0), alone.proposals.boxes.size(0));
  EXPECT_LT(largest_difference(both.proposals.boxes.index_select(0, second), alone.proposals.boxes),
            1e-3);
  EXPECT_LT(largest_difference(both.second.features.index_select(0, second), alone.second.features),
            1e-3);
}

TEST_P(PvRcnnStages, GradientsReachEveryParameter) {
  Network network(small_options(GetParam(), small_autoregressive()));
  network.train();
  const PointBatch batch = batch_of({made_scan(3)}, network.options());
  const Outputs all = run(network, batch);
  const heads::HeadInput input = network.head_input(all.second, all.proposals.boxes);
  const at::Tensor targets = to_box_rows(all.proposals.boxes + 0.05);
  (all.first.scores.square().sum() + all.first.residuals.square().sum() +
   all.first.directions.square().sum() + all.keypoints.logits.square().sum() +
   all.second.confidence.square().sum() + all.second.residuals.square().sum() +
   network.head().loss(input, targets).per_object.sum())
      .backward();
  for (const auto& parameter : network.named_parameters()) {
    ASSERT_TRUE(parameter.value().grad().defined()) << parameter.key();
    EXPECT_TRUE(parameter.value().grad().isfinite().all().item<bool>()) << parameter.key();
    EXPECT_GT(parameter.value().grad().abs().sum().item<double>(), 0) << parameter.key();
  }
  EXPECT_FALSE(all.proposals.boxes.requires_grad());
}

TEST_P(PvRcnnStages, ABatchMovesTheBackbonesStatisticsByTheMomentum) {
  const auto means_after_a_batch = [](const char* momentum) {
    at::manual_seed(3);
    Network network(small_options(GetParam(), {momentum}));
    network.train();
    (void)run(network, batch_of({made_scan(1)}, network.options()));
    std::vector<at::Tensor> means;
    for (const auto& buffer : network.named_buffers()) {
      const bool backbone = buffer.key().starts_with("backbone_");
      if (backbone && buffer.key().ends_with("running_mean")) means.push_back(buffer.value());
    }
    return means;
  };
  const auto little = means_after_a_batch("backbone_norm_momentum=0.1");
  const auto much = means_after_a_batch("backbone_norm_momentum=0.4");
  ASSERT_GT(little.size(), 6U);
  for (std::size_t i = 0; i < little.size(); ++i) {
    EXPECT_GT(little[i].abs().max().item<double>(), 0);
    EXPECT_LT(largest_difference(little[i] * 4, much[i]), 1e-5);
  }
}

TEST_P(PvRcnnStages, ScansWithoutPointsGoThrough) {
  Network network(small_options(GetParam()));
  network.eval();
  const at::NoGradGuard no_gradient;
  const Outputs all = run(network, batch_of({{}, made_scan(1), {}}, network.options()));
  EXPECT_EQ(all.keypoints.counts[0], 0);
  EXPECT_EQ(all.keypoints.counts[2], 0);
  EXPECT_GT(all.keypoints.counts[1], 0);
  EXPECT_TRUE(all.second.features.isfinite().all().item<bool>());
  const Outputs none = run(network, batch_of({{}}, network.options()));
  EXPECT_EQ(none.keypoints.points.size(0), 0);
}

TEST_P(PvRcnnStages, ProposalsAreTheBestAnchorsApart) {
  Network network(small_options(GetParam()));
  unsettle(network);
  network.eval();
  const at::NoGradGuard no_gradient;
  const FirstStage first = network.first_stage(batch_of({made_scan(1)}, network.options()));
  const ProposalOptions options{.candidates = 200, .iou = 0.3, .count = 30};
  const Proposals proposals = network.propose(first, options);

  const auto [scores, labels] = first.scores.max(1);
  std::vector<std::int64_t> order(scores.size(0));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&, s = scores.data_ptr<float>()](auto a, auto b) { return s[a] > s[b]; });
  std::vector<geometry::Box> kept;
  std::vector<std::int64_t> rows;
  for (int i = 0; i < options.candidates && std::ssize(kept) < options.count; ++i) {
    const at::Tensor anchor = network.anchors()[first.anchors[order[i]].item<std::int64_t>()];
    at::Tensor box = decode_residuals(first.residuals[order[i]], anchor);
    box[6] = resolve_directions(box.slice(0, 6, 7), first.directions[order[i]].unsqueeze(0),
                                network.options().anchors.direction_offset)[0];
    const auto number = [&](int k) { return box[k].item<double>(); };
    const auto candidate = geometry::make_yaw_box({number(0), number(1), number(2)},
                                                  {number(3), number(4), number(5)}, number(6));
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const geometry::Box& other) {
      return geometry::overlap(candidate, other, {.space = geometry::OverlapSpace::kBirdsEye}) >
             options.iou;
    });
    if (covered) continue;
    kept.push_back(candidate);
    rows.push_back(order[i]);
  }
  ASSERT_EQ(proposals.boxes.size(0), std::ssize(kept));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_NEAR(proposals.boxes[i][0].item<double>(), kept[i].center.x(), 1e-4);
    EXPECT_EQ(proposals.labels[i].item<std::int64_t>(), labels[rows[i]].item<std::int64_t>());
    EXPECT_EQ(proposals.scores[i].item<float>(), scores[rows[i]].item<float>());
  }
}

TEST(PvRcnnMap, ChannelsAreMadeOfChannelsAndHeights) {
  const at::Tensor coordinates = at::zeros({3, 4}, at::kInt);
  const int places[3][4] = {{0, 1, 2, 0}, {0, 1, 2, 1}, {1, 3, 0, 1}};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) coordinates[i][k] = places[i][k];
  }
  const at::Tensor features = at::arange(1, 16, at::kFloat).view({3, 5});
  const sparse::SparseTensor cells(coordinates, features, {.grid = sparse::Triple{4, 3, 2}}, 2);
  const at::Tensor map = internal::to_map(cells);
  EXPECT_TRUE(map.equal(sparse::birds_eye(cells)));
  EXPECT_EQ(map[0][2 * 3 + 1][2][1].item<float>(), 9);
  EXPECT_TRUE(map.is_contiguous(at::MemoryFormat::ChannelsLast));
}

TEST(PvRcnnMap, ActiveCellsAreThoseOfTheWholeMap) {
  // One block: what is active is as on the whole map, where nothing is reads as zero.
  BirdsEyeOptions options{
      .sparse = true, .channels = {12}, .layers = {1}, .strides = {1}, .up_channels = {8}};
  internal::BirdsEyeBackbone backbone(options, 6);
  backbone.eval();
  const at::NoGradGuard no_gradient;
  std::vector<sparse::Coordinate> places;
  for (int i = 0; i < 40; ++i) {
    const RandomStream stream(1, i, 1);
    const sparse::Coordinate place{0, static_cast<int>(stream.below(0, 20)),
                                   static_cast<int>(stream.below(1, 16)), 0};
    if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  }
  const sparse::SparseTensor cells(sparse::to_tensor(places), at::randn({std::ssize(places), 6}),
                                   {.grid = sparse::Triple{20, 16, 1}}, 1);
  const sparse::SparseTensor active = backbone.forward(cells);
  const at::Tensor whole = backbone.forward(internal::to_map(cells));
  const at::Tensor at_cells = active.coordinates();
  EXPECT_GT(active.size(), cells.size());
  for (std::int64_t i = 0; i < active.size(); ++i) {
    const at::Tensor there = whole[0]
                                 .select(1, at_cells[i][2].item<std::int64_t>())
                                 .select(1, at_cells[i][1].item<std::int64_t>());
    ASSERT_LT(largest_difference(active.features()[i], there), 1e-4) << i;
  }
}

TEST(PvRcnnKeypoints, LieNearTheRegionsOfTheirScan) {
  const Options options = small_options(true);
  const PointBatch batch = batch_of({made_scan(1), made_scan(2)}, options);
  at::Tensor regions = at::zeros({2, kBoxNumbers}), scene = at::zeros({2}, at::kLong);
  for (int i = 0; i < 2; ++i) {
    const float box[] = {3 + 3.0f * i, -5 + 3.0f * i, -1, 4, 2, 1.5f, 0.3f};
    for (int k = 0; k < kBoxNumbers; ++k) regions[i][k] = box[k];
  }
  KeypointOptions wanted = options.keypoints;
  wanted.margin = 0.5;
  const auto near =
      internal::choose_keypoints(batch.points, batch.point_counts, regions, scene, wanted);
  EXPECT_THAT(near.counts, testing::ElementsAre(wanted.count, 0));
  const double radius = 0.5 * std::sqrt(16 + 4 + 2.25) + 0.5;
  for (std::int64_t i = 0; i < near.points.size(0); ++i) {
    const at::Tensor distance = (regions.slice(1, 0, 3) - near.points[i]).norm(2, 1);
    EXPECT_LT(distance.min().item<double>(), radius + 1e-4);
  }
  wanted.around = "scan";
  const auto all =
      internal::choose_keypoints(batch.points, batch.point_counts, regions, scene, wanted);
  EXPECT_THAT(all.counts, testing::ElementsAre(wanted.count, wanted.count));
  EXPECT_TRUE(all.points[0].equal(batch.points[0].slice(0, 0, 3)));
}

TEST(PvRcnnKeypoints, ReadTheMapBetweenItsCells) {
  for (const bool sparse : {false, true}) {
    const Options options =
        small_options(sparse, {"keypoints.points.radii=[]", "keypoints.points.samples=[]",
                               "keypoints.level1.radii=[]", "keypoints.level1.samples=[]",
                               "keypoints.level2.radii=[]", "keypoints.level2.samples=[]"});
    Network network(options);
    network.eval();
    const at::NoGradGuard no_gradient;
    const PointBatch batch = batch_of({made_scan(1)}, options);
    const FirstStage first = network.first_stage(batch);
    const at::Tensor map = sparse ? internal::to_map(*first.cells) : first.map;
    internal::KeypointFeatures features(options, map.size(1));
    const at::Tensor points = batch.points.slice(0, 0, 50).slice(1, 0, 3).contiguous();
    const at::Tensor read = features.gather({points, {50}}, batch, first);
    for (int i = 0; i < 50; ++i) {
      // Cells are half a metre wide, the range begins at (0, -8).
      const double x = points[i][0].item<double>() / 0.5;
      const double y = (points[i][1].item<double>() + 8) / 0.5;
      const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
      if (x0 >= 31 || y0 >= 31) continue;
      const auto cell = [&](int cx, int cy) { return map[0].select(1, cy).select(1, cx); };
      const at::Tensor expected =
          (cell(x0, y0) * (x0 + 1 - x) + cell(x0 + 1, y0) * (x - x0)) * (y0 + 1 - y) +
          (cell(x0, y0 + 1) * (x0 + 1 - x) + cell(x0 + 1, y0 + 1) * (x - x0)) * (y - y0);
      ASSERT_LT(largest_difference(read[i], expected), 1e-4) << i << " sparse " << sparse;
    }
  }
}

TEST(PvRcnnKeypoints, ReadVoxelsAtTheirCentres) {
  // A ball around the centre of one voxel of stride 2 that holds no other centre.
  const Options options =
      small_options(true, {"keypoints.points.radii=[]", "keypoints.points.samples=[]",
                           "keypoints.level1.radii=[]", "keypoints.level1.samples=[]",
                           "keypoints.level2.radii=[0.2]", "keypoints.level2.samples=[4]",
                           "keypoints.birds_eye=none"});
  Network network(options);
  network.eval();
  const at::NoGradGuard no_gradient;
  const PointBatch batch = batch_of({made_scan(1)}, options);
  const FirstStage first = network.first_stage(batch);
  internal::KeypointFeatures features(options, 1);
  features.eval();
  const at::Tensor coordinates = first.levels[1].coordinates();
  const at::Tensor centres = at::zeros({first.levels[1].size() + 1, 3});
  const double low[] = {0, -8, -3}, edge[] = {0.5, 0.5, 1.0};
  for (std::int64_t i = 0; i < first.levels[1].size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      centres[i][axis] = low[axis] + (coordinates[i][1 + axis].item<int>() + 0.5) * edge[axis];
    }
  }
  centres[first.levels[1].size()] = 100;
  const at::Tensor read = features.gather({centres, {first.levels[1].size() + 1}}, batch, first);
  // The shared network on a neighbour at the centre itself.
  at::Tensor rows = first.levels[1].features();
  const auto state = features.named_parameters();
  const double norm = 1 / std::sqrt(1 + 1e-5);
  for (const char* layer : {"0", "3"}) {
    at::Tensor weight = state["SA_layers.0.mlps.0." + std::string(layer) + ".weight"].flatten(1);
    if (layer[0] == '0') weight = weight.slice(1, 3);
    rows = (rows.matmul(weight.t()) * norm).relu();
  }
  EXPECT_LT(largest_difference(read.slice(0, 0, rows.size(0)), rows), 1e-4);
  EXPECT_EQ(read[rows.size(0)].abs().max().item<float>(), 0);
}

}  // namespace
}  // namespace arbox::detectors::pv_rcnn
