#include <ATen/Context.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "arbox/base/options.h"
#include "arbox/training/pv_rcnn_trainee.h"
#include "arbox/training/street_source.h"
#include "arbox/training/train.h"
#include "support/program.h"
#include "training/made_scene.h"
#include "training/tiny_network.h"

namespace arbox::training {
namespace {

constexpr double kNear = 24.0;

/// Simulated streets with cars within the tiny network's range.
ListedScenes streets_with_near_cars(int count) {
  StreetSourceOptions options;
  options.scans.lidar = simulation::LidarKind::kSpinning16;
  options.seed = 1;
  options.min_points = 40;
  const StreetSceneSource source(options, ClassNames({"Car"}));
  std::vector<Scene> scenes;
  for (std::int64_t i = 0; std::ssize(scenes) < count; ++i) {
    Scene scene = source.scene(i);
    std::erase_if(scene.objects, [](const SceneObject& object) {
      return object.box.center.head<2>().lpNorm<Eigen::Infinity>() > kNear;
    });
    for (SceneObject& object : scene.objects) object.difficulty = 0;
    if (scene.objects.size() >= 3) scenes.push_back(std::move(scene));
  }
  return ListedScenes(std::move(scenes));
}

PvRcnnTraineeOptions all_heads() {
  PvRcnnTraineeOptions options;
  options.network = tiny_network();
  options.augmentation.enabled = false;
  // Few steps: boxes count more than usual, and proposals crowd around the objects.
  return override_options(
      options,
      {"network.classes=[Car]", "network.anchors.lengths=[3.9]", "network.anchors.widths=[1.6]",
       "network.anchors.heights=[1.56]", "network.anchors.bottoms=[-1.78]",
       "network.anchors.positive_iou=[0.6]", "network.anchors.negative_iou=[0.45]",
       "network.training_proposals.iou=0.9", "network.proposals.iou=0.9",
       "network.proposals.count=128", "network.regions.pooling.samples=[8]",
       "network.head.name=pointwise", "network.more_heads=[autoregressive, gaussian, discrete]",
       "network.more_head_options=['autoregressive.hidden=[64, 128]', "
       "'discrete.hidden=[64, 128]', 'gaussian.hidden=[64, 128]']",
       "losses.residual=4", "losses.corner=4", "losses.head=4"});
}

TEST(Learning, AFewScansAreOverfittedByEveryHead) {
  TrainOptions options{.steps = 600, .batch_size = 2, .seed = 5, .checkpoint_seconds = 0};
  options.schedule.learning_rate = 0.01;
  options.threads = 1;
  at::manual_seed(options.seed);
  PvRcnnTrainee trainee(all_heads());
  const ListedScenes scenes = streets_with_near_cars(2);
  const arbox::testing::TemporaryDirectory folder;
  Communicator alone;
  TrainObserver silent;
  train({.trainee = trainee, .training = scenes, .options = options, .folder = folder / "run"},
        alone, silent);
  const auto figures = trainee.evaluate(scenes);
  for (const auto& [name, head] : trainee.detector()->heads()) {
    EXPECT_GT(figures.at(name + ": Car found"), 0.9) << name << ": mean IoU of the cars";
  }
}

}  // namespace
}  // namespace arbox::training
