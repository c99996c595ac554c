#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <random>

#include "arbox/training/checkpoint.h"
#include "arbox/training/train_log.h"
#include "support/program.h"
#include "training/child.h"

namespace {

using namespace arbox;
using namespace arbox::training;
using namespace arbox::training::testing;
using arbox::testing::TemporaryDirectory;

std::vector<std::string> arguments(const std::string& folder,
                                   const std::vector<std::string>& more) {
  std::vector<std::string> all = {folder,
                                  "dropout",
                                  "validate",
                                  "steps=40",
                                  "average=0.9",
                                  "checkpoint_interval=1",
                                  "validation_interval=7",
                                  "accumulate=2"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

void expect_same_course(const std::string& folder, const std::string& expected) {
  const TrainHistory got = read_train_log(folder + "/log.jsonl");
  const TrainHistory right = read_train_log(expected + "/log.jsonl");
  ASSERT_EQ(got.steps.size(), right.steps.size());
  for (std::size_t i = 0; i < got.steps.size(); ++i) {
    EXPECT_EQ(got.steps[i].step, right.steps[i].step);
    EXPECT_EQ(got.steps[i].loss, right.steps[i].loss);
    EXPECT_EQ(got.steps[i].learning_rate, right.steps[i].learning_rate);
  }
  ASSERT_EQ(got.validations.size(), right.validations.size());
  for (std::size_t i = 0; i < got.validations.size(); ++i) {
    EXPECT_EQ(got.validations[i].step, right.validations[i].step);
    EXPECT_EQ(got.validations[i].figures, right.validations[i].figures);
  }
}

TEST(Interrupted, KilledAtRandomMomentsEndsWithTheSameWeights) {
  const TemporaryDirectory folder;
  const std::string whole = folder / "whole", killed = folder / "killed";
  run_toy(arguments(whole, {}));
  std::mt19937 random(20);
  std::uniform_int_distribution<int> milliseconds(20, 900);
  int kills = 0;
  for (int attempt = 0; attempt < 200 && kills < 20; ++attempt) {
    // The run is finished now and then; the next one begins anew.
    if (std::filesystem::exists(killed + "/model.arbox")) {
      expect_same_checkpoint(killed, whole);
      std::filesystem::remove_all(killed);
    }
    Child child(arguments(killed, {"resume", "delay=10"}));
    ::usleep(static_cast<useconds_t>(milliseconds(random)) * 1000);
    child.send(SIGKILL);
    const int code = child.wait();
    ASSERT_TRUE(code == 0 || code == 128 + SIGKILL) << child.output();
    if (code != 0) ++kills;
  }
  EXPECT_EQ(kills, 20);
  run_toy(arguments(killed, {"resume"}));
  expect_same_checkpoint(killed, whole);
  expect_same_course(killed, whole);
  EXPECT_EQ(arbox::testing::slurp(killed + "/model.arbox"),
            arbox::testing::slurp(whole + "/model.arbox"));
  // Nothing half-written is left.
  for (const auto& entry : std::filesystem::directory_iterator(killed)) {
    EXPECT_EQ(entry.path().filename().string().find("unfinished"), std::string::npos) << entry;
  }
}

TEST(Interrupted, TerminationEndsCleanlyWithACheckpoint) {
  const TemporaryDirectory folder;
  const std::string whole = folder / "whole", ended = folder / "ended";
  const std::vector<std::string> sparing = {"checkpoint_interval=0"};
  run_toy(arguments(whole, sparing));
  Child child(arguments(ended, {"checkpoint_interval=0", "delay=20"}));
  ASSERT_TRUE(child.wait_for_line("step 5")) << child.output();
  child.send(SIGTERM);
  EXPECT_EQ(child.wait(), 0) << child.output();
  EXPECT_NE(child.output().find("end 1 after"), std::string::npos) << child.output();
  const Checkpoint checkpoint = read_checkpoint(checkpoint_file(ended));
  EXPECT_GE(checkpoint.step, 5);
  EXPECT_LT(checkpoint.step, 40);
  EXPECT_EQ(read_train_log(ended + "/log.jsonl").steps.size(),
            static_cast<std::size_t>(checkpoint.step));
  EXPECT_TRUE(std::filesystem::exists(ended + "/losses.png"));
  EXPECT_FALSE(std::filesystem::exists(ended + "/model.arbox"));
  run_toy(arguments(ended, {"checkpoint_interval=0", "resume"}));
  expect_same_checkpoint(ended, whole);
}

TEST(Interrupted, StopAndContinuePauseTheRun) {
  const TemporaryDirectory folder;
  const std::string whole = folder / "whole", paused = folder / "paused";
  run_toy(arguments(whole, {}));
  const auto start = std::chrono::steady_clock::now();
  Child child(arguments(paused, {"delay=20"}));
  ASSERT_TRUE(child.wait_for_line("step 4")) << child.output();
  child.send(SIGTSTP);
  for (int i = 0; i < 500 && child.state() != 'T'; ++i) ::usleep(2000);
  EXPECT_EQ(child.state(), 'T');
  const std::size_t lines = read_train_log(paused + "/log.jsonl").steps.size();
  ::usleep(1500000);
  EXPECT_EQ(read_train_log(paused + "/log.jsonl").steps.size(), lines);
  child.send(SIGCONT);
  EXPECT_EQ(child.wait(), 0) << child.output();
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  expect_same_checkpoint(paused, whole);
  const TrainHistory log = read_train_log(paused + "/log.jsonl");
  EXPECT_LT(log.steps.back().seconds, passed.count() - 1.4) << "the pause is in the log's times";
}

TEST(Interrupted, TimeLimitEndsWithACheckpointThatGoesOn) {
  const TemporaryDirectory folder;
  const std::string whole = folder / "whole", limited = folder / "limited";
  run_toy(arguments(whole, {}));
  Child child(arguments(limited, {"delay=30", "time_limit=0.4"}));
  EXPECT_EQ(child.wait(), 0);
  EXPECT_NE(child.output().find("end 2 after"), std::string::npos) << child.output();
  run_toy(arguments(limited, {"resume"}));
  expect_same_checkpoint(limited, whole);
}

}  // namespace
