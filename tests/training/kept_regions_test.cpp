#include "arbox/training/pv_rcnn/kept_regions.h"

#include <ATen/Context.h>
#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/zeros.h>
#include <gmock/gmock.h>
#include <torch/csrc/autograd/autograd.h>

#include <fstream>
#include <memory>

#include "arbox/base/error.h"
#include "arbox/training/pv_rcnn/proposal_targets.h"
#include "arbox/training/pv_rcnn_trainee.h"
#include "support/program.h"
#include "training/expect_message.h"
#include "training/made_scene.h"
#include "training/tiny_network.h"

namespace arbox::training {
namespace {

using ::arbox::testing::TemporaryDirectory;
using pv_rcnn::KeptRegions;
using pv_rcnn::KeptRegionsSource;

/// A network whose heads alone learn.
struct HeadsAlone {
  explicit HeadsAlone(const std::string& folder, double foreground_iou = 0.01) {
    at::manual_seed(5);
    PvRcnnTraineeOptions options;
    options.network = tiny_network();
    options.network.regions.shared = {64, 64};
    options.network.regions.dropout = 0.5;
    options.network.head.name = "autoregressive";
    options.augmentation.objects.counts = {};
    // Anchors of a random network lie anywhere.
    options.proposals.foreground_iou = foreground_iou;
    options.keep_regions = folder;
    trainee = std::make_unique<PvRcnnTrainee>(options);
    trainee->network().train();
    for (auto& module : trainee->network().named_modules()) {
      if (is_head(module.key()) || module.key().empty() || module.key() == "roi_head") continue;
      module.value()->eval();
    }
    for (auto& parameter : trainee->network().named_parameters()) {
      if (!is_head(parameter.key())) parameter.value().set_requires_grad(false);
    }
  }

  static bool is_head(const std::string& name) { return name.starts_with("roi_head.box_head"); }

  StepLoss loss(const std::vector<Scene>& scenes) {
    Communicator alone;
    return trainee->loss(scenes, {.number = 0, .seed = 3, .first_scene = 0}, alone);
  }

  std::unique_ptr<PvRcnnTrainee> trainee;
};

TEST(KeptRegions, TheSecondEpochReadsWhatTheFirstOneWroteAndGivesTheSameLoss) {
  const TemporaryDirectory folder;
  HeadsAlone run(folder.path().string());
  const ListedScenes scenes({made_scene(1), made_scene(2)});
  const KeptRegionsSource source(scenes, folder / "kept");
  ASSERT_EQ(source.size(), 2);
  const StepLoss first = run.loss({source.scene(0), source.scene(1)});
  EXPECT_GT(first.terms.at("foreground"), 0);
  const Scene again = source.scene(0);
  ASSERT_TRUE(again.regions);
  EXPECT_TRUE(again.cloud.values.empty()) << "nobody needs the points any more";
  const StepLoss second = run.loss({again, source.scene(1)});
  EXPECT_EQ(first.total.item<double>(), second.total.item<double>());
  EXPECT_EQ(first.terms, second.terms);
  EXPECT_TRUE(second.total.requires_grad());
}

TEST(KeptRegions, AreWhatTheNetworkGivesInDetectionWithoutDropout) {
  HeadsAlone run("unused");
  detectors::pv_rcnn::Network& network = *run.trainee->detector();
  const Scene scene = made_scene(3);
  const KeptRegions some = pv_rcnn::detected_regions(network, scene, scene.objects, 0.01);
  network.eval();
  const KeptRegions other = pv_rcnn::detected_regions(network, scene, scene.objects, 0.01);
  ASSERT_GT(some.features.size(0), 0);
  EXPECT_TRUE(some.features.equal(other.features));
  EXPECT_TRUE(some.residuals.equal(other.residuals));
  EXPECT_EQ(some.objects.size(0), some.boxes.size(0));
}

TEST(KeptRegions, FilesGiveBackEveryNumber) {
  const TemporaryDirectory folder;
  HeadsAlone run("unused");
  const Scene scene = made_scene(4);
  const KeptRegions regions =
      pv_rcnn::detected_regions(*run.trainee->detector(), scene, scene.objects, 0.01);
  pv_rcnn::write_kept_regions(folder / "0.npy", regions);
  const KeptRegions read = pv_rcnn::read_kept_regions(folder / "0.npy");
  EXPECT_TRUE(read.features.equal(regions.features));
  EXPECT_TRUE(read.residuals.equal(regions.residuals));
  EXPECT_TRUE(read.boxes.equal(regions.boxes));
  EXPECT_TRUE(read.objects.equal(regions.objects));
}

TEST(KeptRegions, ScenesWithoutObjectsAreKeptTooAndLearnNothing) {
  const TemporaryDirectory folder;
  HeadsAlone run(folder.path().string());
  Scene without = made_scene(5);
  without.objects.clear();
  const ListedScenes scenes({without});
  const KeptRegionsSource source(scenes, folder.path());
  for (int epoch = 0; epoch < 2; ++epoch) {
    const StepLoss loss = run.loss({source.scene(0)});
    EXPECT_EQ(loss.total.item<double>(), 0);
    EXPECT_EQ(loss.terms.at("foreground"), 0);
  }
  EXPECT_TRUE(source.scene(0).regions);
}

TEST(KeptRegions, AnotherPartThatLearnsIsRefused) {
  HeadsAlone run("unused");
  for (auto& parameter : run.trainee->network().named_parameters()) {
    parameter.value().set_requires_grad(true);
  }
  expect_message<ConfigError>([&] { run.loss({made_scene(1)}); }, "train.frozen");
}

TEST(KeptRegions, FilesOfAnotherShapeAreRefused) {
  const TemporaryDirectory folder;
  for (const char* content : {"", "no array"}) {
    std::ofstream(folder / "0.npy") << content;
    EXPECT_THROW(pv_rcnn::read_kept_regions(folder / "0.npy"), FormatError);
  }
  EXPECT_THROW(pv_rcnn::read_kept_regions(folder / "1.npy"), IoError);
  std::ofstream(folder / "file") << "";
  const ListedScenes scenes({made_scene(1)});
  EXPECT_THROW(KeptRegionsSource(scenes, folder / "file" / "kept"), IoError);
}

TEST(MatchedProposals, AreThoseThatOverlapAnObjectOfTheirClass) {
  const Scene scene = made_scene(6);
  const auto row = [&](std::size_t object, double shift) {
    const geometry::Box& box = scene.objects[object].box;
    return std::vector<double>{box.center.x() + shift, box.center.y(), box.center.z(),
                               box.size.x(),           box.size.y(),   box.size.z(),
                               geometry::yaw(box)};
  };
  detectors::pv_rcnn::Proposals proposals;
  std::vector<at::Tensor> rows;
  for (const auto& numbers : {row(0, 0.0), row(0, 100.0), row(1, 0.3), row(2, 0.0), row(2, 0.0)}) {
    at::Tensor one = at::zeros({1, 7});
    for (int i = 0; i < 7; ++i) one[0][i] = numbers[i];
    rows.push_back(one);
  }
  proposals.boxes = at::cat(rows);
  proposals.labels = at::zeros({5}, at::kLong);
  proposals.labels[4] = 1;
  proposals.scene = at::zeros({5}, at::kLong);
  const auto matched = pv_rcnn::match_proposals(proposals, {scene.objects}, 0.2);
  ASSERT_EQ(matched.rows.numel(), 3);
  EXPECT_EQ(matched.rows[0].item<int>(), 0);
  EXPECT_EQ(matched.rows[1].item<int>(), 2);
  EXPECT_EQ(matched.rows[2].item<int>(), 4) << "the pedestrian, as a pedestrian";
  EXPECT_NEAR(matched.objects[1][0].item<double>(), scene.objects[1].box.center.x(), 1e-5);
}

}  // namespace
}  // namespace arbox::training
