#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "arbox/io/kitti_label.h"
#include "evaluation/kitti_cases.h"
#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::RunResult;
using arbox::testing::slurp;
using arbox::testing::TemporaryDirectory;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr double kTiny = 1e-9;

/// forty_frames() as files, with one false alarm above all finds.
struct KittiFolders {
  TemporaryDirectory root;
  KittiFolders() {
    auto frames = arbox::testing::forty_frames();
    frames[3].predictions.push_back(arbox::testing::false_alarm(1.0));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::string name = std::to_string(100000 + i) + ".txt";
      root.write("labels/" + name, arbox::io::format_kitti_labels(frames[i].labels));
      root.write("results/" + name, arbox::io::format_kitti_results(frames[i].predictions));
    }
  }
  RunResult run(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"evaluate",      "kitti",         "--labels",
                                          root / "labels", "--predictions", root / "results"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_arbox(arguments);
  }
};

TEST(EvaluateKitti, JsonHasApAndCurves) {
  const KittiFolders folders;
  const RunResult result = folders.run({"--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const json report = json::parse(result.output);
  EXPECT_EQ(report.at("overlap"), "iou");
  EXPECT_EQ(report.at("frames"), 40);
  for (const char* metric : {"3d", "bev", "2d", "aos"}) {
    const json& ap = report.at("ap").at("Car").at(metric);
    for (const char* difficulty : {"easy", "moderate", "hard"}) {
      EXPECT_NEAR(ap.at("R40").at(difficulty).get<double>(), 97.5 * 40 / 41, kTiny);
      EXPECT_NEAR(ap.at("R11").at(difficulty).get<double>(), 1000.0 / 11 * 40 / 41, kTiny);
      const json& curve = report.at("curves").at("Car").at(metric).at(difficulty);
      ASSERT_EQ(curve.size(), 41u);
      EXPECT_NEAR(curve.at(0).get<double>(), 40.0 / 41, kTiny);
    }
  }
  EXPECT_FALSE(report.at("ap").contains("Pedestrian"));
}

TEST(EvaluateKitti, WritesTableReportAndPicture) {
  const KittiFolders folders;
  const auto split = folders.root.write("split.txt", "100000\n100001\n");
  const RunResult result = folders.run({"--split", split, "--classes", "Car", "--json",
                                        folders.root / "r.json", "--plot", folders.root / "p.png"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("KITTI, 2 frames"));
  EXPECT_THAT(result.output, HasSubstr("Car: 2 / 2 / 2 labels, 2 predictions"));
  EXPECT_EQ(json::parse(slurp(folders.root / "r.json")).at("frames"), 2);
  EXPECT_EQ(slurp(folders.root / "p.png").substr(1, 3), "PNG");
}

TEST(EvaluateKitti, OverlapsAndClassesCanBeChosen) {
  const KittiFolders folders;
  const auto three_d = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--json", "-"});
    const RunResult result = folders.run(more);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return json::parse(result.output);
  };
  EXPECT_EQ(three_d({"--overlap", "iog"}).at("overlap"), "iog");
  const json loose = three_d({"--classes", "Car", "--min-overlap", "Car=0.7,0.5,0.25"});
  EXPECT_EQ(loose.at("min_overlap").at("Car").at("bev"), 0.5);
  EXPECT_EQ(loose.at("min_overlap").at("Car").at("3d"), 0.25);
  const json tram = three_d({"--classes", "Tram", "--min-overlap", "Tram=0.5"});
  EXPECT_TRUE(tram.at("ap").empty());
}

TEST(EvaluateKitti, BytesDoNotDependOnThreads) {
  const KittiFolders folders;
  const RunResult one = folders.run({"--json", "-", "--threads", "1"});
  EXPECT_EQ(folders.run({"--json", "-", "--threads", "3"}).output, one.output);
}

TEST(EvaluateKitti, WrongUsageIsToldInOneLine) {
  const KittiFolders folders;
  expect_one_line_error(run_arbox({"evaluate"}), 2, {});
  expect_one_line_error(run_arbox({"evaluate", "kitti"}), 2, {"--labels"});
  expect_one_line_error(folders.run({"--overlap", "area"}), 2, {"--overlap"});
  expect_one_line_error(folders.run({"--classes", "Tram"}), 2,
                        {"no minimum overlap for class Tram", "--min-overlap Tram=0.5"});
  expect_one_line_error(folders.run({"--min-overlap", "Car=0.5,0.5"}), 2, {"Car=0.5,0.5"});
  expect_one_line_error(folders.run({"--min-overlap", "Car=1.5"}), 2, {"[0, 1)"});
  expect_one_line_error(folders.run({"--min-overlap", "Bus=0.5"}), 2, {"Bus=0.5"});
}

TEST(EvaluateKitti, BadFilesAreNamed) {
  const KittiFolders folders;
  expect_one_line_error(folders.run({"--plot", "picture.svg"}), 2, {"picture.svg"});
  expect_one_line_error(folders.run({"--split", "no_such_split"}), 1, {"no_such_split"});
  folders.root.write("labels/100007.txt", "Car 0 0 nan 1 2 3 4 1 1 1 0 0 0 0\n");
  expect_one_line_error(folders.run({}), 1, {"100007.txt:1"});
  std::filesystem::remove(folders.root / "labels/100005.txt");
  expect_one_line_error(folders.run({}), 1, {"100005.txt", "no such label file"});
  expect_one_line_error(run_arbox({"evaluate", "kitti", "--labels", "no_such_folder",
                                   "--predictions", folders.root / "results"}),
                        1, {"no_such_folder"});
}

constexpr char kTruth[] =
    R"({"source": "a", "detections": [{"class": "bed", "box": {"center": [0, 0, 0],
        "size": [2, 2, 2], "yaw": 0.3}}, {"class": "bed", "box": {"center": [9, 0, 0],
        "size": [2, 2, 2], "yaw": 0}}]})";
constexpr char kFound[] =
    R"({"source": "a", "detections": [{"class": "bed", "score": 0.5, "box": {"center": [0, 0, 0],
        "size": [2, 2, 2], "yaw": 0.3}}]})";

TEST(EvaluateIndoor, JsonTableAndPicture) {
  const TemporaryDirectory folder;
  const auto truth = folder.write("truth.json", kTruth);
  const auto found = folder.write("found.json", kFound);
  const std::vector<std::string> files = {"evaluate", "indoor",        "--labels",
                                          truth,      "--predictions", found};
  auto arguments = files;
  arguments.insert(arguments.end(), {"--json", "-", "--plot", folder / "p.png"});
  const RunResult result = run_arbox(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const json report = json::parse(result.output);
  EXPECT_EQ(report.at("overlap"), "iou");
  EXPECT_NEAR(report.at("ap").at("bed").at("0.25").get<double>(), 50.0, kTiny);
  EXPECT_NEAR(report.at("recall").at("bed").at("0.50").get<double>(), 50.0, kTiny);
  EXPECT_NEAR(report.at("map").at("mean").get<double>(), 50.0, kTiny);
  EXPECT_EQ(report.at("curves").at("bed").at("0.25").at("recall"), json({0.5}));
  EXPECT_EQ(slurp(folder / "p.png").substr(1, 3), "PNG");
  const RunResult table = run_arbox(files);
  EXPECT_THAT(table.output, HasSubstr("Indoor, 1 scenes, overlap IoU"));
  EXPECT_THAT(table.output, HasSubstr("mean"));
}

TEST(EvaluateIndoor, BadFilesAreNamed) {
  const TemporaryDirectory folder;
  const auto truth = folder.write("truth.json", kTruth);
  const auto broken = folder.write("broken.json", "{");
  expect_one_line_error(
      run_arbox({"evaluate", "indoor", "--labels", truth, "--predictions", broken}), 1,
      {"broken.json:1"});
  expect_one_line_error(
      run_arbox({"evaluate", "indoor", "--labels", truth, "--predictions", "nowhere"}), 1,
      {"nowhere"});
}

/// Two scans: in the first a car is found, in the second nothing.
struct FoundCars {
  TemporaryDirectory root;
  FoundCars() {
    const std::string box =
        R"({"center": [10, 0, 0], "size": [4, 2, 1.5], "rotation": [1, 0, 0, 0]})";
    root.write("truth.jsonl", R"({"source": "a.bin", "detections": [{"class": "Car", "box": )" +
                                  box + "}]}\n" +
                                  R"({"source": "b.bin", "detections": [{"class": "Car", "box": )" +
                                  box + "}]}\n");
    root.write("found.jsonl",
               R"({"source": "a.bin", "detections": [{"class": "Car", "score": 0.8, "box": )" +
                   box + R"(, "uncertainty": 0.2, "quantile_boxes": [{"q": 0.1, "box": )" + box +
                   R"(, "fallback": false}], "samples": [)" + box + R"(]}]})" + "\n" +
                   R"({"source": "b.bin", "detections": []})" + "\n");
  }
  RunResult run(const std::string& truth, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"evaluate",   "uncertainty",   "--labels",
                                          root / truth, "--predictions", root / "found.jsonl"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_arbox(arguments);
  }
};

TEST(EvaluateUncertainty, ScoresJsonAgainstJson) {
  const FoundCars cars;
  const RunResult result = cars.run("truth.jsonl", {"--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const json report = json::parse(result.output);
  EXPECT_EQ(report.at("scans"), 2);
  const json& car = report.at("classes").at("Car");
  EXPECT_EQ(car.at("objects"), 2);
  EXPECT_EQ(car.at("found"), 1);
  EXPECT_NEAR(car.at("mean_iou").get<double>(), 1.0, kTiny);
  EXPECT_EQ(car.at("quantile_boxes").at(0).at("contained"), 1.0);
  EXPECT_EQ(json::parse(cars.run("truth.jsonl", {"--json", "-", "--score", "0.9"}).output)
                .at("all")
                .at("found"),
            0);
}

TEST(EvaluateUncertainty, WritesTableReportAndPicture) {
  const FoundCars cars;
  const RunResult result = cars.run(
      "truth.jsonl",
      {"--measure", "gaussian", "--json", cars.root / "r.json", "--plot", cars.root / "p.png"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("2 scans"));
  EXPECT_EQ(json::parse(slurp(cars.root / "r.json")).at("protocol"), "uncertainty");
  EXPECT_EQ(slurp(cars.root / "p.png").substr(1, 3), "PNG");
}

TEST(EvaluateUncertainty, BadInputIsToldInOneLine) {
  const FoundCars cars;
  expect_one_line_error(cars.run("truth.jsonl", {"--plot", "picture.svg"}), 2, {"picture.svg"});
  expect_one_line_error(cars.run("truth.jsonl", {"--distance", "0"}), 2, {"--distance"});
  expect_one_line_error(cars.run("no_such_file", {}), 1, {"no_such_file"});
  cars.root.write("one.jsonl", R"({"source": "a.bin", "detections": []})");
  expect_one_line_error(cars.run("one.jsonl", {}), 1, {"no labels of scan 'b'"});
  cars.root.write("twice.jsonl",
                  "{\"source\": \"a.bin\", \"detections\": []}\n"
                  "{\"source\": \"x/a.bin\", \"detections\": []}\n");
  expect_one_line_error(cars.run("twice.jsonl", {}), 1, {"'a' stands twice"});
  cars.root.write("label_2/a.txt", "");
  expect_one_line_error(cars.run("label_2", {}), 2, {"--calib"});
}

}  // namespace
