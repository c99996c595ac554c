#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "arbox/geometry/overlap.h"
#include "arbox/io/box_table.h"
#include "arbox/io/detection_json.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/kitti_label.h"
#include "support/program.h"

namespace arbox::testing {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kExamples = ARBOX_EXAMPLES;
const std::string kStreet = (kExamples / "data" / "street.bin").string();
const std::string kCalibration = (kExamples / "data/kitti/training/calib/000000.txt").string();

TEST(Detect, FindsMostCarsOfTheDemoScan) {
  const RunResult result = run_arbox({"detect", kStreet, "--detector", "cluster_fit"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const auto scans = io::parse_detections_json(result.output, "stdout");
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].source, kStreet);
  EXPECT_EQ(scans[0].frame, "lidar");

  const auto calibration = io::read_kitti_calibration(kCalibration);
  int cars = 0, found = 0;
  for (const auto& label :
       io::read_kitti_labels(kExamples / "data/kitti/training/label_2/000000.txt")) {
    const auto truth = io::to_box(label, calibration);
    if (label.type != "Car" || truth.center.head<2>().norm() > 25.0) continue;
    ++cars;
    found += std::any_of(
        scans[0].detections.begin(), scans[0].detections.end(), [&](const auto& detection) {
          return detection.label == "Car" && geometry::overlap(detection.box, truth) > 0.5;
        });
  }
  EXPECT_GE(cars, 6);
  EXPECT_GE(found, 0.7 * cars) << found << " of " << cars;
}

TEST(Detect, WritesEveryFieldThatIsAskedForAndNoOther) {
  const RunResult plain = run_arbox({"detect", kStreet});
  const auto bare = nlohmann::json::parse(plain.output);
  for (const char* absent :
       {"quantile_boxes", "confidence_boxes", "uncertainty", "samples", "log_density"}) {
    EXPECT_FALSE(bare["detections"][0].contains(absent)) << absent;
  }
  const RunResult full = run_arbox({"detect", kStreet, "--quantile", "0.1", "0.5", "--confidence",
                                    "0.9", "--samples", "--score", "0.6", "--seed", "4"});
  ASSERT_EQ(full.exit_code, 0) << full.errors;
  const auto scan = nlohmann::json::parse(full.output);
  ASSERT_FALSE(scan["detections"].empty());
  for (const auto& detection : scan["detections"]) {
    EXPECT_GE(detection["score"], 0.6);
    ASSERT_EQ(detection["quantile_boxes"].size(), 2u);
    EXPECT_EQ(detection["quantile_boxes"][1]["q"], 0.5);
    EXPECT_EQ(detection["confidence_boxes"][0]["p"], 0.9);
    EXPECT_EQ(detection["samples"].size(), 64u);
    EXPECT_GE(detection["uncertainty"], 0.0);
    EXPECT_TRUE(detection["box"].contains("yaw"));
  }
}

TEST(Detect, GivesTheSameBytesAtAnyThreadCount) {
  const std::vector<std::string> arguments = {"detect", kStreet, "--quantile", "0.3"};
  auto one = arguments, two = arguments;
  one.insert(one.end(), {"--threads", "1"});
  two.insert(two.end(), {"--threads", "2"});
  EXPECT_EQ(run_arbox(one).output, run_arbox(two).output);
}

TEST(Detect, ReadsStandardInputAndWritesEveryFormat) {
  const RunOptions piped{.input = slurp(kStreet)};
  const RunResult csv =
      run_arbox({"detect", "-", "--input-format", "bin", "--format", "csv"}, piped);
  ASSERT_EQ(csv.exit_code, 0) << csv.errors;
  const auto table = io::parse_box_table(csv.output, "stdout");
  EXPECT_GE(table.boxes.size(), 8u);
  EXPECT_EQ(table.scores.size(), table.boxes.size());

  const RunResult lines = run_arbox({"detect", kStreet, kStreet, "--format", "jsonl"});
  EXPECT_EQ(std::count(lines.output.begin(), lines.output.end(), '\n'), 2);
  EXPECT_EQ(io::parse_detections_json(lines.output, "stdout").size(), 2u);

  const RunResult array = run_arbox({"detect", kStreet, kStreet});
  EXPECT_EQ(nlohmann::json::parse(array.output).size(), 2u);

  const RunResult kitti =
      run_arbox({"detect", kStreet, "--format", "kitti", "--calib", kCalibration});
  ASSERT_EQ(kitti.exit_code, 0) << kitti.errors;
  const auto results = io::parse_kitti_results(kitti.output, "stdout");
  ASSERT_GE(results.size(), 5u);
  EXPECT_LT(results.size(), table.boxes.size());
  EXPECT_GT(results[0].right, results[0].left);

  const RunResult bare = run_arbox({"detect", kStreet, "--format", "kitti"});
  EXPECT_EQ(io::parse_kitti_results(bare.output, "stdout").size(), table.boxes.size());

  EXPECT_THAT(run_arbox({"detect", kStreet, "--format", "ply"}).output,
              ::testing::StartsWith("ply\n"));
}

TEST(Detect, WritesAFileAScanAndPictures) {
  const TemporaryDirectory folder;
  const std::string bytes = slurp(kStreet);
  folder.write("scans/one.bin", bytes);
  folder.write("scans/two.bin", bytes);
  const RunResult result =
      run_arbox({"detect", (folder / "scans").string(), "--output", (folder / "out").string(),
                 "--view", (folder / "pictures").string()});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "");
  for (const std::string name : {"one", "two"}) {
    EXPECT_EQ(io::read_detections_json(folder.path() / "out" / (name + ".json")).size(), 1u);
    EXPECT_THAT(slurp(folder.path() / "pictures" / (name + ".png")),
                ::testing::StartsWith("\x89PNG"));
  }
  const RunResult lines = run_arbox({"detect", (folder / "scans").string(), "--format", "jsonl",
                                     "--output", (folder / "out").string()});
  EXPECT_EQ(lines.exit_code, 0);
  EXPECT_EQ(io::read_detections_json(folder / "out/detections.jsonl").size(), 2u);
}

TEST(Detect, GoesOnPastABrokenFileAndFailsAtTheEnd) {
  const TemporaryDirectory folder;
  folder.write("scans/a.bin", "123");
  folder.write("scans/b.bin", slurp(kStreet));
  folder.write("scans/c.pcd", "VERSION nonsense\n");
  const RunResult result = run_arbox({"detect", (folder / "scans").string(), "--format", "jsonl"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(io::parse_detections_json(result.output, "stdout").size(), 1u);
  EXPECT_THAT(result.errors, HasSubstr("a.bin"));
  EXPECT_THAT(result.errors, HasSubstr("c.pcd"));
  EXPECT_THAT(result.errors, HasSubstr("2 of 3 inputs failed"));
}

TEST(Detect, GivesNoDetectionsForAnEmptyCloud) {
  const TemporaryDirectory folder;
  const auto empty = folder.write(
      "empty.pcd",
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 0\nDATA ascii\n");
  const RunResult result = run_arbox({"detect", empty.string()});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(nlohmann::json::parse(result.output)["detections"].size(), 0u);
}

TEST(Detect, TakesOptionsOfTheDetector) {
  const TemporaryDirectory folder;
  const auto file = folder.write("options.yaml", "sample_count: 16\n");
  const RunResult result = run_arbox(
      {"detect", kStreet, "--config", file.string(), "--set", "max_range=20", "--samples"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  for (const auto& detection : nlohmann::json::parse(result.output)["detections"]) {
    EXPECT_EQ(detection["samples"].size(), 16u);
    const auto& center = detection["box"]["center"];
    EXPECT_LT(std::hypot(center[0].get<double>(), center[1].get<double>()), 23.0);
  }
}

TEST(Detect, RefusesWrongUsage) {
  expect_one_line_error(run_arbox({"detect"}), 2, {"input"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--detector", "cluster_fix"}), 2,
                        {"cluster_fix", "nearest is 'cluster_fit'"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--quantile", "1.5"}), 2, {"1.5"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--quantile", "half"}), 2, {"half"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--score", "-1"}), 2, {"score"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--format", "xml"}), 2, {"xml"});
  expect_one_line_error(run_arbox({"detect", kStreet, kStreet, "--format", "csv"}), 2,
                        {"--output"});
  expect_one_line_error(run_arbox({"detect", kStreet, kStreet, "--output", "/tmp/x"}), 2,
                        {"one name"});
  expect_one_line_error(run_arbox({"detect", kStreet, kStreet, "--view", "a.png"}), 2, {"folder"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--calib", kCalibration}), 2,
                        {"--format kitti"});
}

TEST(Detect, FailsInOneLineForBadInput) {
  const TemporaryDirectory folder;
  const auto file = [&](const char* name, const std::string& content) {
    return folder.write(name, content).string();
  };
  expect_one_line_error(run_arbox({"detect", (folder / "missing.bin").string()}), 1,
                        {"missing.bin"});
  expect_one_line_error(run_arbox({"detect", file("cut.bin", "12345")}), 1, {"cut.bin"});
  std::filesystem::create_directories(folder / "empty");
  expect_one_line_error(run_arbox({"detect", (folder / "empty").string()}), 1,
                        {"empty", "no point clouds"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--view", "a.gif"}), 2, {"--view", "a.gif"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--set", "tolerance=-1"}), 2,
                        {"--set", "tolerance"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--set", "tollerance=1"}), 2,
                        {"--set", "tollerance", "tolerance"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--config", file("o.yaml", "a: [")}), 1,
                        {"o.yaml"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--format", "kitti", "--calib",
                                   file("calib.txt", "P2: 1 2 3\n")}),
                        1, {"calib.txt"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--output", kStreet + "/under"}), 1,
                        {"street.bin"});
}

}  // namespace
}  // namespace arbox::testing
