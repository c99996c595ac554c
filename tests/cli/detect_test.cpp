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

/// `arbox detect` with the classical detector.
RunResult classical(std::vector<std::string> words, const RunOptions& options = {}) {
  words.insert(words.begin(), {"detect", "--detector", "cluster_fit"});
  return run_arbox(words, options);
}

TEST(Detect, FindsMostCarsOfTheDemoScan) {
  const RunResult result = classical({kStreet});
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
  const RunResult plain = classical({kStreet});
  const auto bare = nlohmann::json::parse(plain.output);
  for (const char* absent :
       {"quantile_boxes", "confidence_boxes", "uncertainty", "samples", "log_density"}) {
    EXPECT_FALSE(bare["detections"][0].contains(absent)) << absent;
  }
  const RunResult full = classical({kStreet, "--quantile", "0.1", "0.5", "--confidence", "0.9",
                                    "--samples", "--score", "0.6", "--seed", "4"});
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
  const std::vector<std::string> arguments = {"detect",      kStreet,      "--detector",
                                              "cluster_fit", "--quantile", "0.3"};
  auto one = arguments, two = arguments;
  one.insert(one.end(), {"--threads", "1"});
  two.insert(two.end(), {"--threads", "2"});
  EXPECT_EQ(run_arbox(one).output, run_arbox(two).output);
}

TEST(Detect, ReadsStandardInputAndWritesEveryFormat) {
  const RunOptions piped{.input = slurp(kStreet)};
  const RunResult csv = classical({"-", "--input-format", "bin", "--format", "csv"}, piped);
  ASSERT_EQ(csv.exit_code, 0) << csv.errors;
  const auto table = io::parse_box_table(csv.output, "stdout");
  EXPECT_GE(table.boxes.size(), 8u);
  EXPECT_EQ(table.scores.size(), table.boxes.size());

  const RunResult lines = classical({kStreet, kStreet, "--format", "jsonl"});
  EXPECT_EQ(std::count(lines.output.begin(), lines.output.end(), '\n'), 2);
  EXPECT_EQ(io::parse_detections_json(lines.output, "stdout").size(), 2u);

  const RunResult array = classical({kStreet, kStreet});
  EXPECT_EQ(nlohmann::json::parse(array.output).size(), 2u);

  const RunResult kitti = classical({kStreet, "--format", "kitti", "--calib", kCalibration});
  ASSERT_EQ(kitti.exit_code, 0) << kitti.errors;
  const auto results = io::parse_kitti_results(kitti.output, "stdout");
  ASSERT_GE(results.size(), 5u);
  EXPECT_LT(results.size(), table.boxes.size());
  EXPECT_GT(results[0].right, results[0].left);

  const RunResult bare = classical({kStreet, "--format", "kitti"});
  EXPECT_EQ(io::parse_kitti_results(bare.output, "stdout").size(), table.boxes.size());

  EXPECT_THAT(classical({kStreet, "--format", "ply"}).output, ::testing::StartsWith("ply\n"));
}

TEST(Detect, WritesAFileAScanAndPictures) {
  const TemporaryDirectory folder;
  const std::string bytes = slurp(kStreet);
  folder.write("scans/one.bin", bytes);
  folder.write("scans/two.bin", bytes);
  const RunResult result =
      classical({(folder / "scans").string(), "--output", (folder / "out").string(), "--view",
                 (folder / "pictures").string()});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "");
  for (const std::string name : {"one", "two"}) {
    EXPECT_EQ(io::read_detections_json(folder.path() / "out" / (name + ".json")).size(), 1u);
    EXPECT_THAT(slurp(folder.path() / "pictures" / (name + ".png")),
                ::testing::StartsWith("\x89PNG"));
  }
  const RunResult lines = classical(
      {(folder / "scans").string(), "--format", "jsonl", "--output", (folder / "out").string()});
  EXPECT_EQ(lines.exit_code, 0);
  EXPECT_EQ(io::read_detections_json(folder / "out/detections.jsonl").size(), 2u);
}

TEST(Detect, GoesOnPastABrokenFileAndFailsAtTheEnd) {
  const TemporaryDirectory folder;
  folder.write("scans/a.bin", "123");
  folder.write("scans/b.bin", slurp(kStreet));
  folder.write("scans/c.pcd", "VERSION nonsense\n");
  const RunResult result = classical({(folder / "scans").string(), "--format", "jsonl"});
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
  const RunResult result = classical({empty.string()});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(nlohmann::json::parse(result.output)["detections"].size(), 0u);
}

TEST(Detect, TakesOptionsOfTheDetector) {
  const TemporaryDirectory folder;
  const auto file = folder.write("options.yaml", "sample_count: 16\n");
  const RunResult result =
      classical({kStreet, "--config", file.string(), "--set", "max_range=20", "--samples"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  for (const auto& detection : nlohmann::json::parse(result.output)["detections"]) {
    EXPECT_EQ(detection["samples"].size(), 16u);
    const auto& center = detection["box"]["center"];
    EXPECT_LT(std::hypot(center[0].get<double>(), center[1].get<double>()), 23.0);
  }
}

/// A copy of the KITTI root of the examples with a second frame and splits.
void write_kitti_root(const TemporaryDirectory& folder) {
  const auto training = kExamples / "data/kitti/training";
  for (const std::string frame : {"000000", "000007"}) {
    for (const std::string file : {"velodyne/000000.bin", "calib/000000.txt"}) {
      const auto name = std::filesystem::path(file);
      folder.write(
          "kitti/training/" + (name.parent_path() / frame).string() + name.extension().string(),
          slurp(training / file));
    }
  }
  folder.write("kitti/ImageSets/val.txt", "000007\n");
  folder.write("kitti/ImageSets/both.txt", "000007\n000000\n");
  folder.write("kitti/ImageSets/none.txt", "\n");
  folder.write("kitti/ImageSets/lost.txt", "000000\n000009\n");
}

TEST(Detect, TakesTheScansOfASplitOfAKittiRoot) {
  const TemporaryDirectory folder;
  write_kitti_root(folder);
  const std::string root = folder / "kitti", out = folder / "out";
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {root, "--split"});
    return classical(more);
  };
  const RunResult kitti = with({"both", "--format", "kitti", "--output", out});
  ASSERT_EQ(kitti.exit_code, 0) << kitti.errors;
  EXPECT_EQ(kitti.errors, "");
  const RunResult direct = classical({kStreet, "--format", "kitti", "--calib", kCalibration});
  for (const char* frame : {"000000", "000007"}) {
    EXPECT_EQ(slurp(folder / "out" / (std::string(frame) + ".txt")), direct.output) << frame;
  }
  const RunResult lines = with({"val", "--format", "jsonl"});
  const auto scans = io::parse_detections_json(lines.output, "stdout");
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].source, root + "/training/velodyne/000007.bin");
  EXPECT_EQ(scans[0].frame, "lidar");
  EXPECT_EQ(nlohmann::json::parse(with({"training"}).output).size(), 2u);
  // A frame that is lost does not end the others.
  const RunResult lost = with({"lost", "--format", "jsonl"});
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_EQ(io::parse_detections_json(lost.output, "stdout").size(), 1u);
  EXPECT_THAT(lost.errors, HasSubstr("000009.bin"));
  EXPECT_THAT(lost.errors, HasSubstr("1 of 2 inputs failed"));
  // The split's calibration is needed for results, and another one may be given.
  std::filesystem::remove(folder / "kitti/training/calib/000007.txt");
  EXPECT_THAT(with({"val", "--format", "kitti", "--output", out}).errors,
              HasSubstr("calib/000007.txt"));
  EXPECT_EQ(with({"val", "--format", "kitti", "--output", out, "--calib", kCalibration}).exit_code,
            0);
}

TEST(Detect, RefusesSplitsThatAreNone) {
  const TemporaryDirectory folder;
  write_kitti_root(folder);
  const std::string root = folder / "kitti", scans = folder / "kitti/training/velodyne";
  expect_one_line_error(run_arbox({"detect", root}), 2,
                        {root, "both, lost, none, val, training", "--split"});
  expect_one_line_error(run_arbox({"detect", root, "--split", "vall"}), 2,
                        {"--split", "both, lost, none, val, training", "'vall'"});
  expect_one_line_error(run_arbox({"detect", root, "--split", "none"}), 1, {"no frames"});
  for (const std::string& input : {scans, kStreet, (folder / "missing").string()}) {
    expect_one_line_error(run_arbox({"detect", input, "--split", "val"}), 2,
                          {"--split", "root of a KITTI dataset", input});
  }
  folder.write("kitti/ImageSets/val.txt", "000007\n../7\n");
  expect_one_line_error(run_arbox({"detect", root, "--split", "val"}), 1, {"val.txt:2", "../7"});
  expect_one_line_error(run_arbox({"detect", "--stdin", "--split", "val"}), 2, {"--split"});
}

TEST(Detect, KnownSizesAreForModelsThatCanUseThem) {
  const TemporaryDirectory folder;
  const auto file = [&](const std::string& content) {
    return folder.write("fleet.csv", content).string();
  };
  const auto refused = [&](const std::string& sizes, int exit_code,
                           const std::vector<std::string>& parts) {
    for (const std::string command : {"detect", "watch"}) {
      const std::string input = command == "detect" ? kStreet : folder.path().string();
      expect_one_line_error(
          run_arbox({command, input, "--detector", "cluster_fit", "--known-sizes", sizes}),
          exit_code, parts);
    }
  };
  refused(file("Car 4 2 1.5\n"), 2, {"--known-sizes", "ClusterFit", "autoregressive"});
  refused(file(""), 1, {"fleet.csv", "class, l, w, h"});
  refused(file("Car 4 2 1.5\nCar 4000 2000 1500\n"), 1, {"fleet.csv:2", "metres", "4000"});
  refused(file("Car 4 nan 1.5\n"), 1, {"fleet.csv:1", "finite"});
  refused((folder / "none.csv").string(), 1, {"none.csv"});
}

TEST(Detect, RefusesWrongUsage) {
  expect_one_line_error(run_arbox({"detect"}), 2, {"input"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--detector", "cluster_fix"}), 2,
                        {"cluster_fix", "nearest is 'cluster_fit'"});
  expect_one_line_error(classical({kStreet, "--quantile", "1.5"}), 2, {"1.5"});
  expect_one_line_error(classical({kStreet, "--quantile", "half"}), 2, {"half"});
  expect_one_line_error(classical({kStreet, "--score", "-1"}), 2, {"score"});
  expect_one_line_error(classical({kStreet, "--format", "xml"}), 2, {"xml"});
  expect_one_line_error(classical({kStreet, kStreet, "--format", "csv"}), 2, {"--output"});
  expect_one_line_error(classical({kStreet, kStreet, "--output", "/tmp/x"}), 2, {"one name"});
  expect_one_line_error(classical({kStreet, kStreet, "--view", "a.png"}), 2, {"folder"});
  expect_one_line_error(classical({kStreet, "--calib", kCalibration}), 2, {"--format kitti"});
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
  expect_one_line_error(classical({kStreet, "--view", "a.gif"}), 2, {"--view", "a.gif"});
  expect_one_line_error(classical({kStreet, "--set", "tolerance=-1"}), 2, {"--set", "tolerance"});
  expect_one_line_error(classical({kStreet, "--set", "tollerance=1"}), 2,
                        {"--set", "tollerance", "tolerance"});
  expect_one_line_error(classical({kStreet, "--config", file("o.yaml", "a: [")}), 1, {"o.yaml"});
  expect_one_line_error(
      classical({kStreet, "--format", "kitti", "--calib", file("calib.txt", "P2: 1 2 3\n")}), 1,
      {"calib.txt"});
  expect_one_line_error(classical({kStreet, "--output", kStreet + "/under"}), 1, {"street.bin"});
  expect_one_line_error(run_arbox({"detect", kStreet, "--model", file("any.arbox", "")},
                                  {.environment = {{"ARBOX_PLUGIN_PATH", "here"}}}),
                        1, {"arbox: error: ARBOX_PLUGIN_PATH: expected absolute folders"});
}

TEST(Detect, TheShippedModelTakesTheLikelierOfKnownSizes) {
  const TemporaryDirectory folder;
  const auto fleet =
      folder.write("fleet.csv", "class,l,w,h,name\nCar,4.2,1.75,1.5,small\nCar,7,2.5,3,van\n");
  const auto result = run_arbox({"detect", ARBOX_EXAMPLES "/data/street.bin", "--model",
                                 "pv_rcnn_compact", "--score", "0.5", "--known-sizes", fleet});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  std::size_t cars = 0;
  const auto detections = nlohmann::json::parse(result.output).at("detections");
  for (const auto& detection : detections) {
    if (detection.at("class") != "Car") {
      EXPECT_FALSE(detection.contains("known_size"));
      continue;
    }
    ++cars;
    ASSERT_TRUE(detection.contains("known_size")) << detection;
    EXPECT_EQ(detection.at("known_size"), nlohmann::json({4.2, 1.75, 1.5}));
    EXPECT_EQ(detection.at("known_size_name"), "small");
    EXPECT_EQ(detection.at("box").at("size"), detection.at("known_size"));
  }
  EXPECT_GT(cars, 8u);
}

TEST(Info, TellsOfInstalledModelsByName) {
  const auto result = run_arbox({"info", "pv_rcnn_compact", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(nlohmann::json::parse(result.output).dump(), HasSubstr("Pedestrian"));
  expect_one_line_error(run_arbox({"info", "pv_rcnn_compakt"}), 1, {"pv_rcnn_compakt"});
}

}  // namespace
}  // namespace arbox::testing
