#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <string>

#include "support/program.h"

namespace arbox::testing {
namespace {

using ::testing::HasSubstr;

const std::string kStreet = ARBOX_EXAMPLES "/data/street.bin";

/// The numbers that follow `before` in a text, one for each time it is there.
std::vector<double> numbers_after(const std::string& text, const std::string& before) {
  std::vector<double> numbers;
  const std::regex pattern(before + "(-?[0-9.e-]+)");
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    numbers.push_back(std::stod((*match)[1]));
  }
  return numbers;
}

void expect_usage(const char* program) {
  EXPECT_EQ(run(program, {}).exit_code, 2);
  const RunResult missing = run(program, {"missing.bin"}, {.timeout_seconds = 120});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.errors, HasSubstr("missing.bin"));
}

void expect_pipeline(const std::string& scan, const std::string& detector, std::size_t objects) {
  const TemporaryDirectory folder;
  const std::string mesh = folder / "boxes.ply";
  const RunResult result = run(PCL_PIPELINE, {scan, detector, mesh}, {.timeout_seconds = 120});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto points = numbers_after(result.output, ": ");
  EXPECT_GE(points.size(), objects) << result.output;
  EXPECT_GT(*std::max_element(points.begin(), points.end()), 100);
  const auto clusters = numbers_after(result.output, "points in ");
  // Most objects are one cluster.
  EXPECT_GT(2 * std::count(clusters.begin(), clusters.end(), 1.0),
            static_cast<std::ptrdiff_t>(clusters.size()));
  EXPECT_EQ(slurp(mesh).substr(0, 3), "ply");
}

TEST(PclPipeline, GivesEachObjectItsClusters) {
  expect_pipeline(kStreet, "cluster_fit", 8);
  expect_usage(PCL_PIPELINE);
}

TEST(PclPipeline, RunsOnARealScan) {
  ARBOX_REQUIRE_DATA(scan, "kitti/training/velodyne/000008.bin");
  expect_pipeline(scan, "cluster_fit", 5);
}

TEST(PclPipeline, TakesATrainedModel) {
  expect_pipeline(kStreet, ARBOX_MODELS "/pv_rcnn_compact.arbox", 12);
}

void expect_plan(const std::string& scan) {
  const RunResult result = run(PLAN_AROUND_BOXES, {scan});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto centers = numbers_after(result.output, "centre occupied with p = ");
  const auto sides = numbers_after(result.output, "side with p = ");
  ASSERT_GE(centers.size(), 4u);
  for (std::size_t i = 0; i < centers.size(); ++i) {
    EXPECT_GT(centers[i], i < 4 ? 0.9 : 0.2);
    EXPECT_LE(centers[i], 1.0);
    EXPECT_LT(sides[i], centers[i] + 1e-9);
  }
  const auto paths = numbers_after(result.output, ": occupied with p = ");
  ASSERT_EQ(paths.size(), 9u);
  const auto best = numbers_after(result.output, ", p = ");
  EXPECT_LT(*std::min_element(paths.begin(), paths.end()), 0.5) << result.output;
  ASSERT_EQ(best.size(), 1u);
  EXPECT_EQ(best[0], *std::min_element(paths.begin(), paths.end()));
  // Who stays clear of the boxes of p = 0.95 meets an object next to never.
  const std::regex clear("occupied with p = ([0-9.e-]+), clear of");
  for (std::sregex_iterator match(result.output.begin(), result.output.end(), clear), end;
       match != end; ++match) {
    EXPECT_LT(std::stod((*match)[1]), 0.3) << result.output;
  }
}

TEST(PlanAroundBoxes, TellsHowLikelyPointsAndPathsAreOccupied) {
  expect_plan(kStreet);
  expect_usage(PLAN_AROUND_BOXES);
}

TEST(PlanAroundBoxes, RunsOnARealScan) {
  ARBOX_REQUIRE_DATA(scan, "kitti/training/velodyne/000008.bin");
  expect_plan(scan);
}

void expect_comparison(const std::string& scan) {
  const RunResult result = run(COMPARE_HEADS, {scan, "60"}, {.timeout_seconds = 120});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto ious = numbers_after(result.output, "mean IoU ");
  ASSERT_EQ(ious.size(), 4u) << result.output;
  EXPECT_GT(*std::min_element(ious.begin(), ious.end()), 0.3) << result.output;
  EXPECT_EQ(numbers_after(result.output, "log density of the truth ").size(), 3u);
  const auto doubt = numbers_after(result.output, "uncertainty ");
  ASSERT_GE(doubt.size(), 8u);
  EXPECT_EQ(doubt.size() % 4, 0u);
  EXPECT_GT(doubt.front(), 0.0);
  EXPECT_NEAR(doubt.back(), 0.0, 1e-12);
}

TEST(CompareHeads, AsksHeadsAboutTheSameEvidence) {
  expect_comparison(kStreet);
  EXPECT_EQ(run(COMPARE_HEADS, {}).exit_code, 2);
}

TEST(CompareHeads, RunsOnARealScan) {
  ARBOX_REQUIRE_DATA(scan, "kitti/training/velodyne/000008.bin");
  expect_comparison(scan);
}

}  // namespace
}  // namespace arbox::testing
