#include "arbox/evaluation/indoor_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "arbox/base/error.h"
#include "support/program.h"

namespace arbox::evaluation {
namespace {

using arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

const std::vector<std::string> kSunRgbdClasses = {"bed",       "table",  "sofa",    "chair",
                                                  "toilet",    "desk",   "dresser", "night_stand",
                                                  "bookshelf", "bathtub"};

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(IndoorGolden, EqualsTheApTableOfVotenetsOwnEvaluation) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd/votenet_pr60_eval8");
  const nlohmann::json table = nlohmann::json::parse(std::ifstream(root / "AP_TABLE.json"));
  int compared = 0;
  for (const auto& [run, expected] : table.at("runs").items()) {
    const auto scenes = read_indoor_scenes(root / run, root / run, kSunRgbdClasses);
    ASSERT_EQ(scenes.size(), 8u);
    const IndoorReport report = evaluate_indoor(scenes);
    for (const std::string threshold : {"0.25", "0.50"}) {
      const std::size_t t = threshold_index(report, std::stod(threshold));
      const nlohmann::json& ap = expected.at("AP").at(threshold);
      for (const IndoorClassResult& result : report.classes) {
        const nlohmann::json& of_class = ap.at(result.name);
        EXPECT_NEAR(result.scores[t].ap / 100, of_class.at("AP").get<double>(), 5.1e-7)
            << run << " " << threshold << " " << result.name;
        EXPECT_NEAR(result.scores[t].recall / 100, of_class.at("max_recall").get<double>(), 5.1e-7);
        EXPECT_EQ(result.truth, expected.at("n_gt").at(result.name).get<std::int64_t>());
        ++compared;
      }
      // The mean is one of rounded figures.
      EXPECT_NEAR(report.class_means[t].ap / 100, ap.at("mAP_over_present_classes").get<double>(),
                  1.1e-6);
    }
  }
  EXPECT_EQ(compared, 18);
}

// A box of 4 x 2 x 1 m, its centre 3 m ahead of the camera, its length along the camera's x.
constexpr char kCorners[] =
    "2,0.5,4,2,0.5,2,-2,0.5,2,-2,0.5,4,2,-0.5,4,2,-0.5,2,-2,-0.5,2,-2,-0.5,4";

TEST(VotenetBoxes, CornersBecomeAnUprightBox) {
  const TemporaryDirectory folder;
  const auto file = folder.write("a_gt_map_cls.txt", std::string("3 ") + kCorners + "\n");
  const auto boxes = read_votenet_boxes(file, false, kSunRgbdClasses);
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_EQ(boxes[0].label, "chair");
  EXPECT_TRUE(boxes[0].box.center.isApprox(Eigen::Vector3d(0, 3, 0)));
  EXPECT_TRUE(boxes[0].box.size.isApprox(Eigen::Vector3d(4, 2, 1)));
  EXPECT_NEAR(geometry::yaw(boxes[0].box), 0.0, 1e-12);
  EXPECT_EQ(read_votenet_boxes(file, false)[0].label, "3");
}

TEST(VotenetBoxes, BadLinesAreRefusedWithTheirPlace) {
  const std::string good = std::string("3 ") + kCorners;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {good, "expected a score"},
      {good + " 0.5 7", "expected the end of the line"},
      {good + " nan", "expected a finite number"},
      {"chair " + std::string(kCorners) + " 1", "expected the number of a class"},
      {"10 " + std::string(kCorners) + " 1", "class 10 has no name"},
      {"3 1,2,3 1", "expected 24 numbers of 8 corners, got 3"},
      {"3 x" + std::string(kCorners) + " 1", "expected a finite number"},
      {"3", "expected a finite number, got ''"},
      {"3 9" + std::string(kCorners) + " 1", "not those of an upright box"},
      {"3 0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0 1", "size of zero"}};
  for (const auto& [line, message] : cases) {
    const TemporaryDirectory folder;
    const auto file = folder.write("a_pred_map_cls.txt", good + " 0.5\n" + line + "\n");
    EXPECT_THAT(error_of([&] { read_votenet_boxes(file, true, kSunRgbdClasses); }),
                ::testing::AllOf(HasSubstr("a_pred_map_cls.txt:2: "), HasSubstr(message)))
        << line;
  }
}

constexpr char kBox[] = R"("box": {"center": [1, 2, 3], "size": [4, 2, 1], "yaw": 0.5})";

std::string scan(const std::string& source, const std::string& label, double score) {
  return R"({"source": ")" + source + R"(", "detections": [{"class": ")" + label +
         R"(", "score": )" + std::to_string(score) + ", " + kBox + "}]}\n";
}

TEST(IndoorFiles, ReadsJsonLinesAndMatchesScenesByName) {
  const TemporaryDirectory folder;
  const auto truth = folder.write("truth.jsonl", scan("b.ply", "chair", 1) + scan("a", "bed", 1));
  const auto found =
      folder.write("found.jsonl", scan("scans/a.pcd", "bed", 0.5) + scan("b", "chair", 0.75));
  const auto scenes = read_indoor_scenes(truth, found);
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0].name, "a");
  EXPECT_EQ(scenes[1].predictions.at(0).score, 0.75);
  EXPECT_EQ(scenes[1].truth.at(0).label, "chair");
}

TEST(IndoorFiles, TellOfEveryFileThatIsRead) {
  const TemporaryDirectory folder;
  for (const char* name : {"truth/a.jsonl", "found/a.jsonl", "truth/b.jsonl", "found/b.jsonl"}) {
    folder.write(name, scan(std::string(1, name[6]), "bed", 1));
  }
  int read = 0;
  read_indoor_scenes(folder / "truth", folder / "found", {}, [&] { ++read; });
  EXPECT_EQ(read, 4);
  EXPECT_EQ(count_indoor_files(folder / "truth", folder / "found"), 4);
}

TEST(IndoorFiles, ReadsFoldersOfJsonAndOfTables) {
  const TemporaryDirectory folder;
  folder.write("truth/a.csv", "class,x,y,z,l,w,h,yaw\nbed,1,2,3,4,2,1,0.5\n");
  folder.write("truth/b.csv", "class,x,y,z,l,w,h,yaw\n");
  folder.write("found/a.json", scan("", "bed", 0.5));
  folder.write("found/b.json", R"({"source": "b", "detections": []})");
  const auto scenes = read_indoor_scenes(folder / "truth", folder / "found");
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_TRUE(scenes[0].truth.at(0).box.center.isApprox(scenes[0].predictions.at(0).box.center));
  EXPECT_TRUE(scenes[1].predictions.empty());
  EXPECT_NEAR(evaluate_indoor(scenes).mean.ap, 100.0, 1e-9);
}

TEST(IndoorFiles, WhatDoesNotFitIsNamed) {
  const TemporaryDirectory folder;
  const auto a = folder.write("a.jsonl", scan("a", "bed", 1));
  const auto ab = folder.write("ab.jsonl", scan("a", "bed", 1) + scan("b", "bed", 1));
  const auto aa = folder.write("aa.jsonl", scan("a", "bed", 1) + scan("x/a.bin", "bed", 1));
  const auto nameless = folder.write("nameless.jsonl", scan("a", "", 1));
  const auto text = folder.write("a.txt", "");
  folder.write("tables/a.csv", "x,y,z,l,w,h,yaw\n1,2,3,4,2,1,0.5\n");
  folder.write("scoreless/a.csv", "class,x,y,z,l,w,h,yaw\nbed,1,2,3,4,2,1,0.5\n");
  folder.write("mixed/a.csv", "");
  folder.write("mixed/b.json", "");
  folder.write("nothing/readme.md", "");
  const auto error = [&](const std::filesystem::path& truth, const std::filesystem::path& found) {
    return error_of([&] { read_indoor_scenes(truth, found); });
  };
  EXPECT_THAT(error(ab, a), HasSubstr("a.jsonl: no predictions of scene 'b'"));
  EXPECT_THAT(error(a, ab), HasSubstr("no truth of the predicted scene 'b'"));
  EXPECT_THAT(error(aa, a), HasSubstr("scene 'a' stands twice"));
  EXPECT_THAT(error(nameless, a), HasSubstr("expected a class with every box"));
  EXPECT_THAT(error(text, a), HasSubstr("expected *.json, *.jsonl or a folder"));
  EXPECT_THAT(error(folder / "no", a), HasSubstr("no such file or folder"));
  EXPECT_THAT(error(folder / "tables", a), HasSubstr("the column class"));
  EXPECT_THAT(error(a, folder / "scoreless"), HasSubstr("the column score"));
  EXPECT_THAT(error(folder / "mixed", a), HasSubstr("expected files of one kind"));
  EXPECT_THAT(error(folder / "nothing", a), HasSubstr("holds no *.json"));
}

}  // namespace
}  // namespace arbox::evaluation
