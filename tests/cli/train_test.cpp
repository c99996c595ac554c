#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "arbox/io/box_table.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"
#include "arbox/io/model_archive.h"
#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::slurp;
using arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

/// A copy of a folder of scans whose labels are the boxes that a model found, each moved a little,
/// every second as if the camera did not see it.
void write_found_labels(const std::string& streets, const std::string& model,
                        const TemporaryDirectory& folder) {
  for (const char* frame : {"000000", "000001", "000002", "000003"}) {
    const std::string calibration =
        slurp(streets + "/training/calib/" + frame + std::string(".txt"));
    const std::string scan = streets + "/training/velodyne/" + frame + ".bin";
    const auto found =
        run_arbox({"detect", scan, "--model", model, "--score", "0", "--format", "csv"});
    ASSERT_EQ(found.exit_code, 0) << found.errors;
    folder.write("found/training/velodyne/" + std::string(frame) + ".bin", slurp(scan));
    folder.write("found/training/calib/" + std::string(frame) + ".txt", calibration);
    const auto boxes = arbox::io::parse_box_table(found.output, "found");
    std::array<std::vector<arbox::io::KittiObject>, 2> objects;
    for (std::size_t i = 0; i < boxes.boxes.size(); ++i) {
      arbox::geometry::Box box = boxes.boxes[i];
      box.center.x() += 0.05 * static_cast<double>(i % 7);
      auto& object = objects[i % 2].emplace_back(arbox::io::to_kitti_object(
          box, arbox::io::parse_kitti_calibration(calibration, "calib")));
      object.type = boxes.classes[i];
      object.truncation = 0;
      object.occlusion = 0;
    }
    const std::string file = "/" + std::string(frame) + ".txt";
    folder.write("found/training/label_2" + file, arbox::io::format_kitti_labels(objects[0], 6));
    folder.write("found/training/label_360" + file, arbox::io::format_kitti_labels(objects[1], 6));
  }
}

/// The sum of "Car 12 objects" lines.
int objects_told(const std::string& output) {
  std::istringstream lines(output);
  int sum = 0, count = 0;
  std::string name, what;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    if (words >> name >> count >> what && what == "objects") sum += count;
  }
  return sum;
}

/// Labels of the benchmark's classes in two frames.
int labels_in(const std::string& folder) {
  int count = 0;
  for (const char* frame : {"/000000.txt", "/000001.txt"}) {
    for (const auto& label : arbox::io::read_kitti_labels(folder + frame)) {
      count += label.type == "Car" || label.type == "Pedestrian" || label.type == "Cyclist";
    }
  }
  return count;
}

/// Two simulated scans, and a small network that is trained on them.
class TrainCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryDirectory;
    const auto made =
        run_arbox({"simulate", "street", "--scenes", "4", "--output", *folder_ / "streets"});
    ASSERT_EQ(made.exit_code, 0) << made.errors;
    folder_->write("train.yaml", "network_file: " + small_network() + R"(
model:
  network:
    more_heads: [gaussian, four_point]
    more_head_options: ["gaussian.hidden=[32]", "four_point.hidden=[32]"]
  augmentation: {objects: {counts: [2, 2, 2]}}
data: {kind: kitti, kitti: {root: )" +
                                     (*folder_ / "streets").string() + R"(, all_round: true}}
train: {steps: 3, batch_size: 1, seed: 5}
)");
  }
  static void TearDownTestSuite() { delete folder_; }

  /// The compact configuration with a smaller range.
  static std::string small_network() {
    std::string text = slurp(ARBOX_CONFIGS "/pv_rcnn_compact.yaml");
    const auto replace = [&](const std::string& from, const std::string& to) {
      const std::size_t place = text.find(from);
      ASSERT_NE(place, std::string::npos) << from;
      text.replace(place, from.size(), to);
    };
    replace("-70.4, -70.4", "-19.2, -19.2");
    replace("70.4, 70.4", "19.2, 19.2");
    return folder_->write("small.yaml", text).string();
  }

  /// The objects of the calibration are, a little moved, what the model itself finds.
  static void calibrate_and_detect(const std::string& model) {
    const std::string scan = path("streets") + "/training/velodyne/000000.bin";
    const std::string root = path("found"), output = path("calibrated.arbox");
    expect_one_line_error(run_arbox({"detect", scan, "--model", model, "--confidence", "0.5"}), 1,
                          {"calibrat"});
    write_found_labels(path("streets"), model, *folder_);
    const std::vector<std::string> calibrate = {"calibrate", model,      "--data",  root,
                                                "--split",   "training", "--score", "0",
                                                "--output",  output};
    const auto of_the_view = run_arbox(calibrate);
    ASSERT_EQ(of_the_view.exit_code, 0) << of_the_view.errors;
    auto all_round = calibrate;
    all_round.insert(all_round.end(), {"--all-round", "--source", "four streets"});
    const auto calibrated = run_arbox(all_round);
    ASSERT_EQ(calibrated.exit_code, 0) << calibrated.errors;
    EXPECT_GT(objects_told(of_the_view.output), 0);
    EXPECT_GT(objects_told(calibrated.output), objects_told(of_the_view.output));
    const auto info = nlohmann::json::parse(run_arbox({"info", output, "--json"}).output);
    EXPECT_EQ(info.at("calibration").at("source"), "four streets");
    EXPECT_THAT(run_arbox({"info", output}).output, HasSubstr("four streets"));
    std::set<std::string> promised;
    for (const auto& [name, one] : info.at("calibration").at("classes").items()) {
      if (one.at("highest_probability") >= 0.5) promised.insert(name);
    }
    ASSERT_FALSE(promised.empty()) << info.at("calibration");
    const auto found =
        run_arbox({"detect", scan, "--model", output, "--score", "0", "--confidence", "0.5"});
    ASSERT_EQ(found.exit_code, 0) << found.errors;
    bool boxes = false;
    const auto detections = nlohmann::json::parse(found.output).at("detections");
    for (const auto& detection : detections) {
      const bool has = detection.contains("confidence_boxes");
      EXPECT_EQ(has, promised.contains(detection.at("class").get<std::string>())) << detection;
      if (has) {
        EXPECT_EQ(detection.at("confidence_boxes").at(0).at("p"), 0.5);
      }
      boxes = boxes || has;
    }
    EXPECT_TRUE(boxes) << detections;
    expect_one_line_error(
        run_arbox({"detect", scan, "--model", output, "--head", "gaussian", "--confidence", "0.5"}),
        1, {"first head"});
    auto sure = all_round;
    *std::next(std::find(sure.begin(), sure.end(), "--score")) = "1";
    expect_one_line_error(run_arbox(sure), 1, {"found none of the labelled objects"});
    std::filesystem::remove_all(root + "/training/label_360");
    expect_one_line_error(run_arbox(all_round), 1, {"label_360"});
  }

  /// Half the size, a card and another default; what it finds differs by the rounding alone.
  static void pack(const std::string& model) {
    const std::string packed = path("packed.arbox");
    const auto card = folder_->write("card.md", "Trained for three steps.\n");
    const auto result = run_arbox(
        {"pack", model, "--half", "--card", card, "--set", "post.nms_iou=0.2", "--output", packed});
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_LT(std::filesystem::file_size(packed), 0.6 * std::filesystem::file_size(model));
    const auto before = arbox::io::read_model_archive(model);
    const auto after = arbox::io::read_model_archive(packed);
    EXPECT_EQ(after.card, "Trained for three steps.\n");
    EXPECT_THAT(after.configuration, HasSubstr("nms_iou: 0.2"));
    ASSERT_EQ(after.records.size(), before.records.size());
    for (const auto& [name, record] : after.records) {
      const auto was = before.records.at(name).values<double>(), is = record.values<double>();
      ASSERT_EQ(is.size(), was.size()) << name;
      for (std::size_t i = 0; i < is.size(); ++i) {
        ASSERT_NEAR(is[i], was[i], 1e-3 * std::abs(was[i]) + 1e-7) << name;
      }
    }
    mix(model);
    const std::string now = path("now.arbox");
    const auto of_run = run_arbox({"pack", path("whole"), "--output", now});
    ASSERT_EQ(of_run.exit_code, 0) << of_run.errors;
    EXPECT_EQ(arbox::io::read_model_archive(now).records, before.records);
    expect_one_line_error(run_arbox({"pack", path("streets"), "--output", now}), 1,
                          {"config.yaml"});
    expect_one_line_error(run_arbox({"pack", "no_such.arbox", "--output", packed}), 1,
                          {"no_such.arbox"});
    expect_one_line_error(run_arbox({"pack", model, "--set", "post.nms_iou=2", "--output", packed}),
                          1, {"nms_iou"});
  }

  /// With itself a model stays what it is but for its calibration, which other weights break.
  static void mix(const std::string& model) {
    const std::string mixed = path("mixed.arbox"), calibrated = path("calibrated.arbox");
    const auto result = run_arbox({"pack", calibrated, "--average", model, "--share", "0.3",
                                   "--average-except", "box_heads", "--output", mixed});
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    const auto before = arbox::io::read_model_archive(calibrated);
    const auto after = arbox::io::read_model_archive(mixed);
    EXPECT_FALSE(before.calibration.empty());
    EXPECT_TRUE(after.calibration.empty()) << after.calibration;
    for (const auto& [name, record] : after.records) {
      const auto was = before.records.at(name).values<double>(), is = record.values<double>();
      for (std::size_t i = 0; i < is.size(); ++i) {
        ASSERT_NEAR(is[i], was[i], 1e-6 * std::abs(was[i])) << name;
      }
    }
    expect_one_line_error(run_arbox({"pack", model, "--share", "0.3", "--output", mixed}), 2,
                          {"--share", "--average"});
    expect_one_line_error(
        run_arbox({"pack", model, "--average", "no_such.arbox", "--output", mixed}), 1,
        {"no_such.arbox"});
    expect_one_line_error(
        run_arbox({"pack", model, "--average", "pv_rcnn_compact", "--output", mixed}), 1,
        {"unknown box_heads.discrete"});
  }

  /// The whole benchmark, on two scans.
  static void compare(const std::string& model) {
    const auto result =
        run_arbox({"benchmark", "--data", path("streets"), "--split", "training", "--scans", "2",
                   "--all-round", "--model", model, "--score", "0", "--found-score", "0", "--timed",
                   "1", "--output", path("results")});
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.output, HasSubstr("| gaussian | q 0.20 |"));
    EXPECT_THAT(result.output, HasSubstr("| uncertainty of | boxes |"));
    const auto report = nlohmann::json::parse(slurp(path("results") + "/benchmark.json"));
    std::set<std::string> rows;
    for (const auto& row : report.at("rows")) {
      rows.insert(row.at("detector").get<std::string>() + " " + row.at("box").get<std::string>());
      EXPECT_EQ(row.at("iou").at("overlap"), "iou");
      EXPECT_EQ(row.at("iog").at("overlap"), "iog");
      EXPECT_EQ(row.at("recall").at("frames"), 2);
      const bool timed = row.at("detector") != "cluster_fit" || row.at("box") == "box";
      EXPECT_EQ(row.at("median_milliseconds").is_number(), timed) << row.at("detector");
    }
    for (const std::string head : {"autoregressive", "gaussian"}) {
      for (const char* box : {" beam", " mean", " q 0.10", " q 0.20", " q 0.40", " q 0.50"}) {
        EXPECT_TRUE(rows.contains(head + box)) << head << box;
      }
      EXPECT_FALSE(rows.contains(head + " q 0.80")) << "is for the ranking by uncertainty";
      EXPECT_EQ(report.at("uncertainty").at(head).at("all").at("objects"),
                labels_in(path("streets") + "/training/label_2") +
                    labels_in(path("streets") + "/training/label_360"));
    }
    // The network has learnt for three steps and need not find anything.
    const auto& of_cluster_fit = report.at("uncertainty").at("cluster_fit").at("all");
    ASSERT_GT(of_cluster_fit.at("found"), 0);
    const auto& last = of_cluster_fit.at("quantile_boxes").back();
    EXPECT_EQ(last.at("q"), 0.8);
    EXPECT_EQ(last.at("boxes"), of_cluster_fit.at("found"));
    EXPECT_TRUE(last.contains("roc_auc") && last.contains("spearman"));
    EXPECT_TRUE(last.at("expected").at("wrong").is_number()) << "its samples say";
    EXPECT_EQ(of_cluster_fit.at("overlaps").size(), 3u);
    EXPECT_TRUE(rows.contains("pointwise pointwise"));
    EXPECT_TRUE(rows.contains("four_point box"));
    EXPECT_FALSE(rows.contains("four_point q 0.20")) << "it has one box";
    EXPECT_TRUE(rows.contains("cluster_fit box"));
    EXPECT_TRUE(report.at("uncertainty").contains("gaussian, G"));
    for (const char* name : {"average_precision.png", "promises.png",
                             "precision_recall_autoregressive.png", "benchmark.md"}) {
      EXPECT_FALSE(slurp(path("results") + "/" + name).empty()) << name;
    }
    expect_one_line_error(run_arbox({"benchmark", "--data", path("streets"), "--split", "night"}),
                          1, {"night"});
    expect_one_line_error(run_arbox({"benchmark", "--data", path("streets"), "--split", "training",
                                     "--no-cluster-fit"}),
                          2, {"expected a model or cluster_fit"});
  }

  static std::string path(const char* name) { return (*folder_ / name).string(); }

  static TemporaryDirectory* folder_;
};

TemporaryDirectory* TrainCommand::folder_ = nullptr;

TEST_F(TrainCommand, TrainsEndsAndResumes) {
  const auto whole = run_arbox({"train", path("train.yaml"), "--output", path("whole")});
  ASSERT_EQ(whole.exit_code, 0) << whole.errors;
  EXPECT_THAT(whole.output, HasSubstr("trained 3 steps: " + path("whole") + "/model.arbox"));
  EXPECT_THAT(whole.errors, HasSubstr("step 3/3"));
  std::istringstream log(slurp(path("whole") + "/log.jsonl"));
  int lines = 0;
  for (std::string line; std::getline(log, line); ++lines) {
    EXPECT_EQ(nlohmann::json::parse(line).at("step"), lines + 1);
  }
  EXPECT_EQ(lines, 3);
  const auto part =
      run_arbox({"train", path("train.yaml"), "--output", path("part"), "train.time_limit=0.001"});
  ASSERT_EQ(part.exit_code, 0) << part.errors;
  EXPECT_THAT(part.output, HasSubstr("go on with: arbox train --resume " + path("part")));
  EXPECT_FALSE(std::filesystem::exists(path("part") + "/model.arbox"));
  const auto rest = run_arbox({"train", "--resume", path("part"), "train.time_limit=0"});
  ASSERT_EQ(rest.exit_code, 0) << rest.errors;
  EXPECT_EQ(slurp(path("part") + "/model.arbox"), slurp(path("whole") + "/model.arbox"));

  const std::string scan = path("streets") + "/training/velodyne/000000.bin";
  for (const char* head : {"autoregressive", "gaussian"}) {
    const auto found = run_arbox({"detect", scan, "--model", path("whole") + "/model.arbox",
                                  "--head", head, "--score", "0", "--quantile", "0.2"});
    ASSERT_EQ(found.exit_code, 0) << found.errors;
    const auto detections = nlohmann::json::parse(found.output).at("detections");
    ASSERT_FALSE(detections.empty()) << head;
    EXPECT_EQ(detections[0].at("quantile_boxes").size(), 1);
    EXPECT_TRUE(detections[0].contains("uncertainty"));
  }

  calibrate_and_detect(path("whole") + "/model.arbox");
  compare(path("whole") + "/model.arbox");
  pack(path("whole") + "/model.arbox");

  expect_one_line_error(run_arbox({"train", path("train.yaml"), "--output", path("whole")}), 1,
                        {"holds a training run"});
  expect_one_line_error(run_arbox({"train", "--resume", path("whole"), "train.seed=9"}), 1,
                        {"seed was 5, is now 9"});
}

// The example of docs/training.md.
TEST_F(TrainCommand, HeadsLearnOnTheFrozenFeaturesOfARun) {
  const auto base = run_arbox({"train", path("train.yaml"), "model.network.head.name=pointwise",
                               "model.network.more_heads=[]", "model.network.more_head_options=[]",
                               "--output", path("base")});
  ASSERT_EQ(base.exit_code, 0) << base.errors;
  const auto heads =
      run_arbox({"train", path("train.yaml"), "--output", path("heads"),
                 "train.initial=" + path("base") + "/model.arbox",
                 "train.initial_except=[roi_head.box_head, box_heads]",
                 "train.frozen=[backbone_3d, backbone_2d, dense_head, pfe, point_head, "
                 "roi_head.roi_grid_pool_layer,\n  roi_head.shared_fc_layer, roi_head.cls_layers, "
                 "roi_head.reg_layers]"});
  ASSERT_EQ(heads.exit_code, 0) << heads.errors;
  const auto before = arbox::io::read_model_archive(path("base") + "/model.arbox").records;
  const auto after = arbox::io::read_model_archive(path("heads") + "/model.arbox").records;
  std::size_t learnt = 0;
  for (const auto& [name, record] : after) {
    if (name.starts_with("roi_head.box_head") || name.starts_with("box_heads.")) {
      ++learnt;
    } else {
      EXPECT_EQ(record, before.at(name)) << name;
    }
  }
  EXPECT_GT(learnt, 8u);
  EXPECT_EQ(after.size(), before.size() + learnt);
}

TEST_F(TrainCommand, WrongUseIsExplained) {
  expect_one_line_error(run_arbox({"train"}), 2, {"expected a CONFIG file, or --resume DIR"});
  expect_one_line_error(run_arbox({"train", "--resume", "/no/such/folder"}), 2,
                        {"/no/such/folder"});
  expect_one_line_error(run_arbox({"train", "--resume", path("streets"), path("train.yaml")}), 2,
                        {"--resume takes the configuration of its folder"});
  expect_one_line_error(run_arbox({"train", "--resume", path("streets")}), 1, {"config.yaml"});
  expect_one_line_error(run_arbox({"train", path("none.yaml")}), 1, {"none.yaml"});
  const auto wrong = [&](const std::string& change, const std::string& part) {
    expect_one_line_error(
        run_arbox({"train", path("train.yaml"), "--output", path("wrong"), change}), 1, {part});
  };
  wrong("train.stepps=4", "'train.steps'");
  wrong("data.kind=none", "data.kind: expected kitti or street");
  wrong("data.kitti.root=/no/such/data", "/no/such/data");
  wrong("train.accumulate=2", "accumulate");
  wrong("train.frozen=[backbone_9]", "nearest is");
  wrong("network_file=none.yaml", "none.yaml");
  expect_one_line_error(run_arbox({"train", path("train.yaml"), "--output", path("wrong")},
                                  {.environment = {{"WORLD_SIZE", "x"}}}),
                        1, {"WORLD_SIZE"});
}

TEST_F(TrainCommand, ConfigurationsOfTheProjectAreValid) {
  for (const char* name : {"train_compact_street.yaml", "train_compact_folder.yaml",
                           "train_compact_shipped.yaml", "train_pv_rcnn_kitti.yaml"}) {
    const auto result =
        run_arbox({"config", "check", "train/pv_rcnn", std::string(ARBOX_CONFIGS "/") + name});
    EXPECT_EQ(result.exit_code, 0) << result.errors;
  }
}

}  // namespace
