#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/program.h"

// What a person could hand in by mistake, through every command that reads it: one line on standard
// error that names the file, nothing on standard output, exit code 1.
namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::TemporaryDirectory;
using Words = std::vector<std::string>;

struct Content {
  std::string name;
  std::string bytes;
};

class BadInput : public ::testing::Test {
 protected:
  BadInput() {
    folder_.write("boxes.csv", "0,0,0,4,2,1.5,0.1\n");
    folder_.write("cloud.csv", "x,y,z\n1,2,3\n4,5,6\n");
    folder_.write("dir/label_2/000000.txt", kLabel);
    folder_.write("dir/results/000000.txt", std::string(kLabel) + " 0.5");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Runs `words` with FILE replaced by `file`, and other names by their paths in the folder.
  void expect_refused(Words words, const std::string& file) const {
    for (std::string& word : words) {
      if (word == "FILE") word = path(file);
      if (word.starts_with("@")) word = path(word.substr(1));
    }
    SCOPED_TRACE(::testing::PrintToString(words));
    expect_one_line_error(run_arbox(words), 1, {file});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.png"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.pcd"));
  }

  void expect_all_refused(const std::vector<Words>& commands, const std::string& extension,
                          const std::vector<Content>& contents) const {
    std::filesystem::create_directories(folder_ / ("directory" + extension));
    for (const Words& words : commands) {
      for (const Content& content : contents) {
        folder_.write(content.name + extension, content.bytes);
        expect_refused(words, content.name + extension);
      }
      expect_refused(words, "missing" + extension);
      expect_refused(words, "directory" + extension);
    }
  }

  static constexpr char kLabel[] = "Car 0 0 0 600 150 700 250 1.5 1.6 3.9 1.0 1.5 20.0 0.1";

  TemporaryDirectory folder_;
};

const std::vector<Words> kCloudCommands = {{"detect", "FILE", "--detector", "cluster_fit"},
                                           {"info", "FILE"},
                                           {"convert", "FILE", "@out.pcd"},
                                           {"view", "--cloud", "FILE", "--output", "@out.png"}};

TEST_F(BadInput, PointClouds) {
  const std::string header = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  expect_all_refused(
      kCloudCommands, ".pcd",
      {{"empty", ""},
       {"prose", "This is no point cloud.\n"},
       {"absurd", header + "WIDTH 1000000000000\nHEIGHT 1\nPOINTS 1000000000000\nDATA binary\n"},
       {"truncated", header + "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary\n123456789012345678"},
       {"columns", header + "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2\n"}});
  expect_all_refused(kCloudCommands, ".bin",
                     {{"empty", ""}, {"truncated", std::string(1001, '\1')}});
  expect_all_refused(kCloudCommands, ".csv",
                     {{"empty", ""}, {"words", "x,y,z\n1,2,three\n"}, {"columns", "1,2\n"}});
}

TEST_F(BadInput, BoxTables) {
  expect_all_refused(
      {{"overlap", "--measure", "iou", "--first", "FILE", "--second", "@boxes.csv"},
       {"overlap", "--measure", "iou", "--first", "@boxes.csv", "--second", "FILE"},
       {"nms", "FILE"},
       {"quantile-box", "--quantile", "0.1", "--samples", "FILE"},
       {"view", "--cloud", "@cloud.csv", "--output", "@out.png", "--boxes", "FILE"},
       {"view", "--cloud", "@cloud.csv", "--output", "@out.png", "--labels", "FILE"}},
      ".csv",
      {{"prose", "This is no table.\n"},
       {"nan", "x,y,z,l,w,h,yaw,score\n0,0,0,4,2,1.5,nan,1\n"},
       {"infinite", "x,y,z,l,w,h,yaw,score\n0,inf,0,4,2,1.5,0,1\n"},
       {"flat", "x,y,z,l,w,h,yaw,score\n0,0,0,4,0,1.5,0,1\n"},
       {"quaternion", "x,y,z,l,w,h,qw,qx,qy,qz,score\n0,0,0,4,2,1.5,1,1,0,0,1\n"},
       {"columns", "0,0,0,4,2\n"},
       {"cut", "x,y,z,l,w,h,yaw,score\n0,0,0,4,2,1.5,0,1\n0,0,0,4"}});
}

TEST_F(BadInput, DetectionsAsJson) {
  const auto box = [](const std::string& inside) {
    return R"({"source": "a", "detections": [{"class": "Car", "score": 1, "box": )" + inside +
           "}]}\n";
  };
  expect_all_refused(
      {{"view", "--cloud", "@cloud.csv", "--output", "@out.png", "--boxes", "FILE"},
       {"evaluate", "indoor", "--labels", "FILE", "--predictions", "FILE"}},
      ".json",
      {{"prose", "This is no JSON.\n"},
       {"cut", R"({"source": "a", "detections": [)"},
       {"number", "42\n"},
       {"boxless", R"({"source": "a", "detections": [{"class": "Car"}]})"},
       {"flat", box(R"({"center": [0, 0, 0], "size": [1, 0, 1], "yaw": 0})")},
       {"nan", box(R"({"center": [NaN, 0, 0], "size": [1, 1, 1], "yaw": 0})")},
       {"short", box(R"({"center": [0, 0], "size": [1, 1, 1], "yaw": 0})")},
       {"quaternion",
        box(R"({"center": [0, 0, 0], "size": [1, 1, 1], "rotation": [2, 0, 0, 0]})")}});
}

TEST_F(BadInput, KittiFiles) {
  for (const std::string& bad :
       {std::string("Car 0 0 0 600 150 700 250 1.5 1.6"), "Car " + std::string(14 * 2, ' ') + "x",
        std::string("Car 0 0 0 600 150 700 250 nan 1.6 3.9 1.0 1.5 20.0 0.1")}) {
    folder_.write("bad/000000.txt", bad + "\n");
    expect_refused({"evaluate", "kitti", "--labels", "@bad", "--predictions", "@dir/results"},
                   "000000.txt:1");
    folder_.write("bad/000000.txt", bad + " 0.5\n");
    expect_refused({"evaluate", "kitti", "--labels", "@dir/label_2", "--predictions", "@bad"},
                   "000000.txt:1");
  }
  std::filesystem::create_directories(folder_ / "none");
  const Words evaluate = {"evaluate", "kitti", "--labels", "@dir/label_2", "--predictions"};
  for (const std::string place : {"none", "missing", "boxes.csv"}) {
    Words words = evaluate;
    words.push_back("FILE");
    expect_refused(words, place);
    expect_refused({"info", "kitti", "FILE"}, place);
  }
  folder_.write("names.txt", "000000\n000001\n");
  Words words = evaluate;
  words.insert(words.end(), {"@dir/results", "--split", "@names.txt"});
  expect_refused(words, "000001.txt");
}

TEST_F(BadInput, Configurations) {
  expect_all_refused(
      {{"config", "check", "nms", "FILE"},
       {"config", "show", "nms", "--file", "FILE"},
       {"detect", "@cloud.csv", "--detector", "cluster_fit", "--config", "FILE"}},
      ".yaml",
      {{"prose", "This is: no: YAML\n"}, {"unknown", "threshhold: 0.5\n"}, {"list", "- 1\n- 2\n"}});
}

TEST_F(BadInput, OutputsThatCannotBeWritten) {
  std::filesystem::create_directories(folder_ / "taken.png");
  std::filesystem::create_directories(folder_ / "taken.json");
  std::filesystem::create_directories(folder_ / "taken.pcd");
  const Words kitti = {"evaluate",     "kitti",         "--labels",
                       "@dir/label_2", "--predictions", "@dir/results"};
  const auto with = [](Words words, const std::string& flag) {
    words.insert(words.end(), {flag, "FILE"});
    return words;
  };
  for (const std::string place : {"nowhere/a", "taken"}) {
    expect_refused({"convert", "@cloud.csv", "FILE"}, place + ".pcd");
    expect_refused({"view", "--cloud", "@cloud.csv", "--output", "FILE"}, place + ".png");
    expect_refused({"detect", "@cloud.csv", "--detector", "cluster_fit", "--view", "FILE"},
                   place + ".png");
    expect_refused(with(kitti, "--plot"), place + ".png");
    expect_refused(with(kitti, "--json"), place + ".json");
    const Words quantile = {"quantile-box", "--samples", "@boxes.csv", "--quantile", "0.1"};
    expect_refused(with(quantile, "--json"), place + ".json");
    expect_refused(with(quantile, "--csv"), place + ".json");
  }
  expect_refused({"detect", "@cloud.csv", "--detector", "cluster_fit", "--output", "FILE"},
                 "boxes.csv");
}

TEST_F(BadInput, NoFileIsAPlugin) {
  folder_.write("prose.so", "This is no library.\n");
  expect_refused({"plugins", "check", "FILE"}, "prose.so");
  expect_refused({"plugins", "check", "FILE"}, "missing.so");
}

}  // namespace
