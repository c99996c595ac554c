#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "arbox/drawing/image.h"
#include "io/made_kitti.h"
#include "support/program.h"

namespace arbox {
namespace {

using nlohmann::json;
using testing::expect_one_line_error;
using testing::run_arbox;
using testing::TemporaryDirectory;

TEST(DatasetCommands, InitInfoAndConvertOfOnesOwnData) {
  const TemporaryDirectory folder;
  const std::string own = (folder / "own").string();
  const auto init = run_arbox({"init", own, "--classes", "Car"});
  EXPECT_EQ(init.exit_code, 0) << init.errors;
  EXPECT_NE(init.output.find("made dataset.json"), std::string::npos);
  EXPECT_NE(init.output.find("next: put clouds"), std::string::npos);
  folder.write("own/points/a.csv", "x,y,z\n8,0.1,0\n9,-0.4,0.4\n");
  folder.write("own/labels/a.txt", "8.5 0 0 2 1.2 1 0 Car\n50 0 0 2 1 1 370 Car\n");
  const auto info = run_arbox({"info", own});
  EXPECT_EQ(info.exit_code, 0) << info.errors;
  for (const char* part : {"layout arbox, frame lidar", "all: 1 scans, 1 with labels, 2 objects",
                           "1 boxes hold no points", "a object 1 (Car)", "beyond a full turn"}) {
    EXPECT_NE(info.output.find(part), std::string::npos) << part << "\n" << info.output;
  }
  const std::string kitti = (folder / "kitti").string();
  const auto convert = run_arbox({"convert", own, kitti, "--to-layout", "kitti", "--json"});
  EXPECT_EQ(convert.exit_code, 0) << convert.errors;
  EXPECT_EQ(json::parse(convert.output).at("objects"), 2);
  const auto checked = run_arbox({"info", kitti, "--json"});
  EXPECT_EQ(checked.exit_code, 0) << checked.errors;
  const json report = json::parse(checked.output);
  EXPECT_EQ(report.at("layout"), "kitti");
  EXPECT_EQ(report.at("checks")[0].at("classes").at("Car").at("objects"), 2);
}

TEST(DatasetCommands, ConvertRenamesAndLeavesOutClasses) {
  const TemporaryDirectory folder;
  testing::make_kitti(folder);
  const std::string out = (folder / "out").string();
  const auto result = run_arbox({"convert", folder.path().string(), out, "--to-layout",
                                 "sunrgbd-votenet", "--class-map", "Car=bed"});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_NE(result.output.find("3 scenes, 3 objects"), std::string::npos) << result.output;
  EXPECT_NE(result.errors.find("3 objects of class Cyclist were left out"), std::string::npos)
      << result.errors;
  expect_one_line_error(run_arbox({"convert", folder.path().string(), out}), 1, {"new or empty"});
  EXPECT_EQ(
      run_arbox({"convert", out, (folder / "x").string(), "--to-layout", "nuscenes"}).exit_code, 2);
}

TEST(DatasetCommands, WhatCannotBeReadIsToldOrPassedOver) {
  const TemporaryDirectory folder;
  testing::make_kitti(folder);
  folder.write("training/label_2/000002.txt", "Car 1 2\n");
  const std::string root = folder.path().string();
  expect_one_line_error(run_arbox({"convert", root, (folder / "a").string()}), 1, {"000002.txt:1"});
  const auto passed = run_arbox({"convert", root, (folder / "b").string(), "--skip-broken"});
  EXPECT_EQ(passed.exit_code, 0) << passed.errors;
  EXPECT_NE(passed.errors.find("1 scenes could not be read"), std::string::npos);
  const auto info = run_arbox({"info", root, "--split", "val"});
  EXPECT_NE(info.output.find("1 scans cannot be read"), std::string::npos) << info.output;
  expect_one_line_error(run_arbox({"info", (folder / "training/planes").string()}), 1,
                        {"looks like no dataset"});
  expect_one_line_error(run_arbox({"info", root, "--split", "no"}), 1, {"'no'"});
}

TEST(DatasetCommands, ViewDrawsAScene) {
  const TemporaryDirectory folder;
  testing::make_kitti(folder);
  std::filesystem::remove_all(folder / "training/image_2");
  const std::string picture = (folder / "a.png").string();
  const auto result = run_arbox({"view", "--dataset", folder.path().string(), "--scene", "000002",
                                 "--output", picture, "--width", "400"});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(drawing::read_image(picture).width, 400);
  expect_one_line_error(
      run_arbox({"view", "--dataset", folder.path().string(), "--scene", "9", "--output", picture}),
      2, {"'9'"});
  expect_one_line_error(run_arbox({"view", "--output", picture}), 2, {"--cloud", "--dataset"});
}

TEST(EvaluateBoxes, PrintsTheMeans) {
  const TemporaryDirectory folder;
  const auto truth =
      folder.write("t.csv", "object,x,y,z,l,w,h,yaw\n1,0,0,0,1,1,1,0\n2,0,0,0,1,1,1,0\n");
  const auto found =
      folder.write("p.csv", "object,x,y,z,l,w,h,yaw\n2,0,0,0,1,1,1,0\n1,0,0,0,2,1,1,0\n");
  const auto result = run_arbox({"evaluate", "boxes", "--labels", truth.string(), "--predictions",
                                 found.string(), "--json", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const json report = json::parse(result.output);
  EXPECT_DOUBLE_EQ(report.at("mean_iou"), 0.75);
  EXPECT_DOUBLE_EQ(report.at("mean_iog"), 1.0);
  EXPECT_DOUBLE_EQ(report.at("err_dim"), 0.5);
  const auto one = folder.write("one.csv", "object,x,y,z,l,w,h,yaw\n2,0,0,0,1,1,1,0\n");
  expect_one_line_error(
      run_arbox({"evaluate", "boxes", "--labels", truth.string(), "--predictions", one.string()}),
      1, {"object 1"});
}

TEST(EvaluateBoxes, TakesEveryFormThatIsWritten) {
  const TemporaryDirectory folder;
  const std::string box = R"({"center": [0, 0, 0], "size": [1, 1, 1], "yaw": 0})";
  const std::string wide = R"({"center": [0, 0, 0], "size": [2, 1, 1], "yaw": 0})";
  const auto scan = [](const std::string& source, const std::string& boxes) {
    return R"({"source": ")" + source + R"(", "detections": [)" + boxes + "]}\n";
  };
  const auto one = [](const std::string& b) { return R"({"box": )" + b + "}"; };
  const auto mean_iou = [&](const std::filesystem::path& labels,
                            const std::filesystem::path& predictions,
                            std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {
        "evaluate",           "boxes",  "--labels", labels.string(), "--predictions",
        predictions.string(), "--json", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run_arbox(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return result.exit_code == 0 ? json::parse(result.output).at("mean_iou").get<double>() : -1.0;
  };
  const auto csv = folder.write("t.csv", "x,y,z,l,w,h,yaw\n0,0,0,1,1,1,0\n0,0,0,1,1,1,0\n");
  const auto found = folder.write("p.json", scan("a.bin", one(box) + "," + one(wide)));
  EXPECT_DOUBLE_EQ(mean_iou(csv, found), 0.75);
  const auto own = folder.write("own.json", R"({"objects": [{"class": "a", "box": )" + box +
                                                R"(}, {"class": "a", "box": )" + wide + "}]}");
  EXPECT_DOUBLE_EQ(mean_iou(own, found), 1.0);
  const auto text = folder.write("own.txt", "0 0 0 1 1 1 0 a\n0 0 0 1 1 1 0 a\n");
  EXPECT_DOUBLE_EQ(mean_iou(text, found), 0.75);
  // Several scans are matched by their names, whatever their order and folders.
  const auto truth =
      folder.write("t.jsonl", scan("x/b.bin", one(wide)) + scan("x/a.bin", one(box)));
  const auto lines = folder.write("p.jsonl", scan("a.bin", one(box)) + scan("b.bin", one(wide)));
  EXPECT_DOUBLE_EQ(mean_iou(truth, lines), 1.0);
  const auto evaluate = [&](const std::filesystem::path& labels,
                            const std::filesystem::path& predictions) {
    return run_arbox(
        {"evaluate", "boxes", "--labels", labels.string(), "--predictions", predictions.string()});
  };
  const auto other = folder.write("o.jsonl", scan("a.bin", one(box)) + scan("c.bin", one(wide)));
  expect_one_line_error(evaluate(truth, other), 1, {"o.jsonl", "scan b", "got none"});
  const auto more =
      folder.write("m.jsonl", scan("a.bin", one(box) + "," + one(box)) + scan("b.bin", one(wide)));
  expect_one_line_error(evaluate(truth, more), 1, {"m.jsonl", "one more of scan a"});
  expect_one_line_error(evaluate(csv, folder.write("n.json", scan("a", one(box)))), 1,
                        {"n.json", "each of the 2", "got 1"});
  // What arbox detect writes in KITTI's form, against KITTI's labels.
  testing::make_kitti(folder);
  const auto labels = folder / "training/label_2/000001.txt";
  std::string results;
  for (const std::string line :
       {"Car 0.00 0 1.20 100.00 150.00 200.00 250.00 1.50 1.75 4.25 -2.50 1.75 20.00 1.10 0.9\n",
        "Cyclist 0 0 0.2 300 150 320 200 1.70 0.60 1.80 1.50 1.75 30.00 0.25 0.8\n"}) {
    results += line;
  }
  EXPECT_NEAR(mean_iou(labels, folder.write("r.txt", results),
                       {"--calib", (folder / "training/calib/000001.txt").string()}),
              1.0, 1e-9);
}

TEST(DatasetCommands, ConvertWritesEveryLayout) {
  const TemporaryDirectory folder;
  testing::make_kitti(folder);
  const std::string root = folder.path().string();
  for (const std::string layout :
       {"scannet", "scannet-votenet", "scannet-mmdet3d", "sunrgbd", "sunrgbd-votenet",
        "sunrgbd-mmdet3d", "sunrgbd-toolbox", "labelcloud", "cvat", "arbox", "kitti"}) {
    const std::string out = (folder / layout).string();
    const auto result = run_arbox({"convert", root, out, "--to-layout", layout, "--class-map",
                                   "Car=bed", "--class-map", "Cyclist=chair", "--infos", "1.0"});
    EXPECT_EQ(result.exit_code, 0) << layout << result.errors;
    EXPECT_NE(result.output.find("3 scenes, 6 objects"), std::string::npos) << result.output;
    const auto info = run_arbox({"info", out, "--json"});
    EXPECT_EQ(info.exit_code, 0) << layout << info.errors;
    EXPECT_NE(info.output.find("\"layout\": \"" + layout + "\""), std::string::npos);
  }
  const auto scannet = run_arbox({"convert", root, (folder / "again").string(), "--to-layout",
                                  "scannet", "--class-map", "Car=bed"});
  EXPECT_NE(scannet.errors.find("3 objects without points are lost"), std::string::npos)
      << scannet.errors;
  expect_one_line_error(
      run_arbox({"convert", root, (folder / "bins").string(), "--to-layout", "cob3d"}), 1,
      {"depth images, no clouds"});
}

}  // namespace
}  // namespace arbox
