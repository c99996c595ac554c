#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/made_kitti.h"
#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::TemporaryDirectory;
using nlohmann::json;

TEST(InfoKitti, TellsClassesMissingAndBrokenFilesOfEachSplit) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  folder.write("ImageSets/train.txt", "000001\n000003\n000004\n");
  folder.write("training/label_2/000001.txt", "Car 1 2\n");
  const auto result = run_arbox({"info", "kitti", folder.path().string()});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  for (const char* part :
       {"train: 3 frames in training", "val: 1 frames", "Cyclist                1",
        "velodyne               2       1       0  missing: 000004",
        "label_2                2       1       1", "000001.txt:1: expected 15 fields",
        "planes                 1       2       0  (optional)"}) {
    EXPECT_NE(result.output.find(part), std::string::npos) << part << "\n" << result.output;
  }
}

TEST(InfoKitti, JsonHoldsTheWholeReport) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  folder.write("training/calib/000003.txt", "P2: 1 2 3\n");
  const auto result =
      run_arbox({"info", "kitti", folder.path().string(), "--json", "--split", "train"});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const json report = json::parse(result.output);
  ASSERT_EQ(report.at("splits").size(), 1u);
  const json& split = report["splits"][0];
  EXPECT_EQ(split.at("frames"), 2);
  EXPECT_EQ(split.at("objects").at("Car"), 2);
  EXPECT_EQ(split.at("files").at("planes").at("missing"), json::array({"000003"}));
  const std::string broken = split.at("files").at("calib").at("broken").at(0);
  EXPECT_NE(broken.find("000003.txt:1: expected 12 numbers after P2, got 3"), std::string::npos);
}

TEST(InfoKitti, WhatCannotBeReadIsOneLineAndOne) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  const std::string root = folder.path().string();
  expect_one_line_error(run_arbox({"info", "kitti", root + "/none"}), 1, {"does not exist"});
  expect_one_line_error(run_arbox({"info", "kitti", root + "/training"}), 1, {"parent folder"});
  expect_one_line_error(run_arbox({"info", "kitti", root, "--split", "trian"}), 1,
                        {"train, val, training", "'trian'"});
  EXPECT_EQ(run_arbox({"info", "kitti"}).exit_code, 2);
}

TEST(InfoKitti, ReportsTheRealSample) {
  ARBOX_REQUIRE_DATA(root, "kitti");
  const auto result =
      run_arbox({"info", "kitti", "--json", "--split", "sample,test", root.string()});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const json report = json::parse(result.output);
  EXPECT_EQ(report["splits"][0]["frames"], 13);
  EXPECT_EQ(report["splits"][0]["files"]["velodyne"]["present"], 13);
  EXPECT_EQ(report["splits"][1]["files"]["velodyne"]["missing"].size(), 7518u);
}

}  // namespace
