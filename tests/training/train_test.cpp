#include "arbox/training/train.h"

#include <ATen/TensorOperators.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/drawing/image.h"
#include "arbox/training/checkpoint.h"
#include "arbox/training/network_state.h"
#include "arbox/training/train_log.h"
#include "arbox/training/weights_file.h"
#include "support/program.h"
#include "training/expect_message.h"
#include "training/toy_trainee.h"

namespace {

using namespace arbox;
using namespace arbox::training;
using namespace arbox::training::testing;
using arbox::testing::TemporaryDirectory;

struct Recorder : TrainObserver {
  std::vector<StepReport> steps;
  std::vector<ValidationReport> validations;
  std::vector<std::int64_t> checkpoints;
  std::int64_t stop_after = -1;

  void on_step(const StepReport& report) override { steps.push_back(report); }
  void on_validation(const ValidationReport& report) override { validations.push_back(report); }
  void on_checkpoint(const std::filesystem::path&, std::int64_t step) override {
    checkpoints.push_back(step);
  }
  bool stop_requested() override {
    return stop_after >= 0 && static_cast<std::int64_t>(steps.size()) >= stop_after;
  }
};

struct ToyRun {
  TrainOptions options{.steps = 30, .batch_size = 4};
  ToyScenes scenes{24};
  ToyScenes validation{3, 2};
  bool validates = false;
  bool resume = false;
  Recorder recorder;
  ToyTrainee trainee{ToyOptions{}};

  TrainResult operator()(const std::filesystem::path& folder) {
    Communicator alone;
    return train({.trainee = trainee,
                  .training = scenes,
                  .validation = validates ? &validation : nullptr,
                  .options = options,
                  .folder = folder,
                  .resume = resume},
                 alone, recorder);
  }
};

TEST(Train, LearnsAndLeavesItsFiles) {
  const TemporaryDirectory folder;
  ToyRun run;
  run.options.steps = 0;
  run.options.epochs = 50;
  run.options.schedule.learning_rate = 0.05;
  run.options.validation_interval = 100;
  run.options.best = "closeness";
  run.validates = true;
  const TrainResult result = run(folder / "run");
  EXPECT_EQ(result.end, TrainEnd::kFinished);
  EXPECT_EQ(result.steps, 300);
  EXPECT_EQ(result.skipped, 0);
  EXPECT_LT(run.recorder.steps.back().loss, 0.2 * run.recorder.steps.front().loss);
  EXPECT_NEAR(run.recorder.steps.back().epoch, 50, 1e-9);
  ASSERT_EQ(run.recorder.validations.size(), 3u);
  EXPECT_EQ(run.recorder.checkpoints, std::vector<std::int64_t>{300});
  for (const char* name :
       {"log.jsonl", "losses.png", "checkpoint.arbox", "model.arbox", "best.arbox"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / "run" / name)) << name;
  }
  EXPECT_GT(drawing::read_image(folder / "run" / "losses.png").width, 100);
  // The model is the network as it was trained.
  ToyTrainee loaded{ToyOptions{}};
  load_weights(loaded.network(), folder / "run" / "model.arbox");
  loaded.network().eval();
  EXPECT_NEAR(loaded.evaluate(run.validation).at("error"),
              run.recorder.validations.back().figures.at("error"), 0.05);
}

TEST(Train, SameSeedSameWeightsOtherSeedOthers) {
  const TemporaryDirectory folder;
  ToyRun one, again, other;
  other.options.seed = 8;
  again.options.loader_threads = 3;
  one.options.loader_threads = 0;
  one(folder / "one");
  again(folder / "again");
  other(folder / "other");
  const auto weights = [](ToyRun& run) { return network_tensors(run.trainee.network()); };
  bool differs = false;
  for (const auto& [name, tensor] : weights(one)) {
    EXPECT_TRUE(tensor.equal(weights(again).at(name))) << name;
    differs |= !tensor.equal(weights(other).at(name));
  }
  EXPECT_TRUE(differs);
}

TEST(Train, AStepWithoutFiniteNumbersIsSkipped) {
  const TemporaryDirectory folder;
  ToyRun run;
  run.scenes.poisoned = 3;
  const TrainResult result = run(folder / "run");
  EXPECT_EQ(result.skipped, 5);  // 30 steps of 4 scenes see each of 24 scenes 5 times.
  for (const auto& [name, tensor] : network_tensors(run.trainee.network())) {
    EXPECT_TRUE(tensor.isfinite().all().item<bool>()) << name;
  }
  const TrainHistory log = read_train_log(folder / "run" / "log.jsonl");
  EXPECT_EQ(std::count_if(log.steps.begin(), log.steps.end(),
                          [](const StepReport& step) { return step.skipped; }),
            5);
}

TEST(Train, TooManySkippedStepsEndTheRun) {
  const TemporaryDirectory folder;
  ToyRun run;
  run.scenes = ToyScenes(2);
  run.scenes.poisoned = 1;
  run.options.batch_size = 2;
  run.options.max_skipped = 4;
  expect_message<NumericalError>([&] { run(folder / "run"); }, "toy scene 1");
  EXPECT_EQ(read_checkpoint(checkpoint_file(folder / "run")).step, 5);
}

TEST(Train, FrozenPartsKeepWeightsAndStatistics) {
  const TemporaryDirectory folder;
  ToyRun run;
  run.options.frozen = {"conv1", "norm1"};
  NamedTensors before;
  for (const auto& [name, tensor] : network_tensors(run.trainee.network())) {
    before[name] = tensor.clone();
  }
  run(folder / "run");
  for (const auto& [name, tensor] : network_tensors(run.trainee.network())) {
    const bool frozen = name.starts_with("conv1") || name.starts_with("norm1");
    EXPECT_EQ(frozen, tensor.equal(before.at(name))) << name;
  }
}

TEST(Train, BeginsWithGivenWeights) {
  const TemporaryDirectory folder;
  ToyRun first;
  first(folder / "first");
  ToyRun second;
  second.options.initial = folder / "first" / "checkpoint.arbox";
  second.options.steps = 1;
  second.options.schedule.learning_rate = 1e-9;
  second(folder / "second");
  const NamedTensors expected = network_tensors(first.trainee.network());
  for (const auto& [name, tensor] : network_tensors(second.trainee.network())) {
    if (name.find("weight") == std::string::npos) continue;
    EXPECT_TRUE(tensor.allclose(expected.at(name), 1e-5, 1e-6)) << name;
  }
}

TEST(Train, StopsWhenAskedAndGoesOn) {
  const TemporaryDirectory folder;
  ToyRun whole;
  whole(folder / "whole");
  ToyRun part;
  part.recorder.stop_after = 11;
  const TrainResult stopped = part(folder / "part");
  EXPECT_EQ(stopped.end, TrainEnd::kStopped);
  EXPECT_EQ(stopped.steps, 11);
  ToyRun rest;
  rest.resume = true;
  rest.options.loader_threads = 2;
  EXPECT_EQ(rest(folder / "part").end, TrainEnd::kFinished);
  EXPECT_EQ(rest.recorder.steps.front().step, 12);
  const NamedTensors expected = network_tensors(whole.trainee.network());
  for (const auto& [name, tensor] : network_tensors(rest.trainee.network())) {
    EXPECT_TRUE(tensor.equal(expected.at(name))) << name;
  }
  // A finished run that is resumed has nothing to do.
  ToyRun done;
  done.resume = true;
  EXPECT_EQ(done(folder / "part").steps, 30);
  EXPECT_TRUE(done.recorder.steps.empty());
}

TEST(Train, AValidationThatIsStoppedIsDoneOnResuming) {
  const TemporaryDirectory folder;
  ToyRun run;
  run.validates = true;
  run.options.validation_interval = 10;
  run.recorder.stop_after = 10;
  EXPECT_EQ(run(folder / "run").steps, 10);
  EXPECT_TRUE(run.recorder.validations.empty());
  ToyRun rest;
  rest.validates = true;
  rest.options.validation_interval = 10;
  rest.resume = true;
  rest(folder / "run");
  ASSERT_EQ(rest.recorder.validations.size(), 3u);
  EXPECT_EQ(rest.recorder.validations[0].step, 10);
}

TEST(Train, AnUnreadableSceneEndsTheRunWithACheckpoint) {
  const TemporaryDirectory folder;
  ToyRun run;
  run.scenes.missing = 5;
  expect_message<IoError>([&] { run(folder / "run"); }, "scene 5: no such file");
  const Checkpoint checkpoint = read_checkpoint(checkpoint_file(folder / "run"));
  EXPECT_EQ(checkpoint.step, static_cast<std::int64_t>(run.recorder.steps.size()));
  ToyRun whole;
  whole(folder / "whole");
  ToyRun rest;
  rest.resume = true;
  rest(folder / "run");
  const NamedTensors expected = network_tensors(whole.trainee.network());
  for (const auto& [name, tensor] : network_tensors(rest.trainee.network())) {
    EXPECT_TRUE(tensor.equal(expected.at(name))) << name;
  }
}

TEST(Train, WhatDoesNotFitIsRefused) {
  const TemporaryDirectory folder;
  ToyRun()(folder / "run");
  expect_message<ConfigError>([&] { ToyRun()(folder / "run"); }, "holds a training run");
  const auto resumed = [&](const auto& change) {
    ToyRun run;
    run.resume = true;
    change(run);
    run(folder / "run");
  };
  expect_message<ConfigError>(
      [&] { resumed([](ToyRun& run) { run.options.schedule.learning_rate = 0.5; }); },
      "schedule.learning_rate was 0.01, is now 0.5");
  expect_message<ConfigError>([&] { resumed([](ToyRun& run) { run.scenes = ToyScenes(23); }); },
                              "begun with 24 scenes");
  const auto refused = [&](const auto& change, const std::string& part) {
    ToyRun run;
    change(run);
    expect_message<ConfigError>([&] { run(folder / "other"); }, part);
  };
  refused([](ToyRun& run) { run.options.accumulate = 3; }, "accumulate");
  refused([](ToyRun& run) { run.options.batch_size = 0; }, "batch_size");
  refused([](ToyRun& run) { run.scenes = ToyScenes(0); }, "no scenes");
  refused([](ToyRun& run) { run.options.steps = 0, run.options.epochs = 0; }, "steps or epochs");
  refused([](ToyRun& run) { run.options.frozen = {"conv9"}; }, "nearest is 'conv1'");
  refused(
      [](ToyRun& run) {
        run.options.frozen = {"conv1", "norm1", "conv2", "norm2", "weight", "bias", "unused"};
      },
      "no part of the network is left");
  refused(
      [](ToyRun& run) {
        run.validates = true;
        run.options.best = "closenes";
      },
      "nearest is 'closeness'");
}

}  // namespace
