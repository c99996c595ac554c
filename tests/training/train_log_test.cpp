#include "arbox/training/train_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/training/active_clock.h"
#include "arbox/training/train_figure.h"
#include "support/program.h"

namespace {

using namespace arbox;
using namespace arbox::training;
using arbox::testing::slurp;
using arbox::testing::TemporaryDirectory;

StepReport report(std::int64_t step) {
  StepReport result;
  result.step = step;
  result.steps = 10;
  result.epoch = 0.5 * static_cast<double>(step);
  result.loss = 1.0 / static_cast<double>(step);
  result.terms = {{"box", 0.25}, {"class", 0.1 / static_cast<double>(step)}};
  result.learning_rate = 0.1;
  result.momentum = 0.9;
  result.gradient_norm = 3;
  result.seconds = 2.5;
  result.scenes_per_second = 4;
  return result;
}

TEST(TrainLog, ComesBackAsItWasWritten) {
  const TemporaryDirectory folder;
  TrainLog log(folder / "log.jsonl", 0, -1);
  StepReport bad = report(2);
  bad.loss = std::numeric_limits<double>::quiet_NaN();
  bad.skipped = true;
  log.write(report(1));
  log.write(bad);
  log.write(ValidationReport{2, {{"Car", 0.5}}, 1.5});
  const TrainHistory history = read_train_log(folder / "log.jsonl");
  ASSERT_EQ(history.steps.size(), 2u);
  EXPECT_EQ(history.steps[0].terms, report(1).terms);
  EXPECT_EQ(history.steps[0].loss, 1.0);
  EXPECT_EQ(history.steps[0].scenes_per_second, 4);
  EXPECT_TRUE(std::isnan(history.steps[1].loss));
  EXPECT_TRUE(history.steps[1].skipped);
  ASSERT_EQ(history.validations.size(), 1u);
  EXPECT_EQ(history.validations[0].figures.at("Car"), 0.5);
  EXPECT_NE(slurp(folder / "log.jsonl").find("\"loss\":null"), std::string::npos);
}

TEST(TrainLog, WhatWasWrittenAfterTheCheckpointIsCutOff) {
  const TemporaryDirectory folder;
  {
    TrainLog log(folder / "log.jsonl", 0, -1);
    for (std::int64_t step = 1; step <= 4; ++step) log.write(report(step));
    log.write(ValidationReport{4, {}, 1});
    log.write(report(5));
  }
  const std::string whole = slurp(folder / "log.jsonl");
  const auto steps_left = [&](std::int64_t step, std::int64_t validated, const std::string& end) {
    folder.write("log.jsonl", whole + end);
    const TrainLog log(folder / "log.jsonl", step, validated);
    const TrainHistory history = read_train_log(folder / "log.jsonl");
    EXPECT_EQ(history.steps.size(), log.history().steps.size());
    EXPECT_EQ(history.validations.size(), validated == 4 ? 1u : 0u);
    return history.steps.size();
  };
  EXPECT_EQ(steps_left(5, 4, R"({"step": 6, "ste)"), 5u);
  EXPECT_EQ(steps_left(4, 4, ""), 4u);
  EXPECT_EQ(steps_left(4, -1, ""), 4u);
  EXPECT_EQ(steps_left(2, -1, ""), 2u);
  EXPECT_EQ(steps_left(0, -1, "garbage\n"), 0u);
}

TEST(TrainLog, FolderThatIsMissingIsAnError) {
  EXPECT_THROW(TrainLog("/no/such/folder/log.jsonl", 0, -1), IoError);
}

TEST(TrainFigure, DrawsShortLongAndOddCourses) {
  TrainHistory history;
  EXPECT_FALSE(draw_training(history).empty());
  history.steps.push_back(report(1));
  EXPECT_FALSE(draw_training(history).empty());
  for (std::int64_t step = 2; step < 5000; ++step) history.steps.push_back(report(step));
  history.steps[100].loss = std::numeric_limits<double>::infinity();
  history.steps[101].terms.clear();
  history.validations.push_back({1000, {{"Car", 0.5}, {"Pedestrian", std::nan("")}}, 1});
  history.validations.push_back({2000, {{"Car", 0.6}}, 1});
  const drawing::Image image = draw_training(history);
  EXPECT_GT(image.width, 1000);
  EXPECT_GT(image.height, 600);
}

TEST(ActiveClock, RunsWithTheTime) {
  ActiveClock clock;
  const double begin = clock.seconds();
  ::usleep(300000);
  const double passed = clock.seconds() - begin;
  EXPECT_GE(passed, 0.29);
  EXPECT_LT(passed, 3);
}

}  // namespace
