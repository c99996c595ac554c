#include "arbox/io/kitti_label.h"

#include <gtest/gtest.h>

#include <limits>

#include "io/expect_refusal.h"
#include "support/program.h"

namespace {

using arbox::io::format_kitti_labels;
using arbox::io::format_kitti_results;
using arbox::io::KittiObject;
using arbox::io::parse_kitti_labels;
using arbox::io::parse_kitti_results;
using arbox::testing::expect_refusal;

constexpr const char* kLabels =
    "Car 0.25 1 -1.50 100.00 150.50 200.00 250.00 1.50 1.75 4.25 -2.50 1.75 20.00 -1.62\n"
    "DontCare -1 -1 -10 5.00 6.00 7.00 8.00 -1 -1 -1 -1000 -1000 -1000 -10\n";

TEST(KittiLabel, FieldsAreReadInTheFilesOrder) {
  const auto objects = parse_kitti_labels(kLabels, "t");
  ASSERT_EQ(objects.size(), 2u);
  const KittiObject& car = objects[0];
  EXPECT_EQ(car.type, "Car");
  EXPECT_EQ(car.truncation, 0.25);
  EXPECT_EQ(car.occlusion, 1);
  EXPECT_EQ(car.alpha, -1.5);
  EXPECT_EQ(car.left, 100);
  EXPECT_EQ(car.top, 150.5);
  EXPECT_EQ(car.right, 200);
  EXPECT_EQ(car.bottom, 250);
  EXPECT_EQ(car.height, 1.5);
  EXPECT_EQ(car.width, 1.75);
  EXPECT_EQ(car.length, 4.25);
  EXPECT_EQ(car.x, -2.5);
  EXPECT_EQ(car.y, 1.75);
  EXPECT_EQ(car.z, 20);
  EXPECT_EQ(car.rotation_y, -1.62);
  EXPECT_TRUE(has_box(car));
  EXPECT_FALSE(has_box(objects[1]));
}

TEST(KittiLabel, WrittenLabelsAreTheTextThatWasRead) {
  EXPECT_EQ(format_kitti_labels(parse_kitti_labels(kLabels, "t")), kLabels);
}

TEST(KittiLabel, WrittenResultsReadBackWithinTheirDecimals) {
  KittiObject object{.type = "Cyclist", .alpha = 1.23456, .left = 1.5, .score = 0.1234567};
  object.height = object.width = object.length = 1.0 / 3.0;
  object.x = object.y = object.z = 10.0 / 3.0;
  object.rotation_y = -1.1;
  const auto read = parse_kitti_results(format_kitti_results(std::vector{object}), "t");
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].truncation, -1);
  EXPECT_EQ(read[0].occlusion, -1);
  EXPECT_NEAR(read[0].alpha, object.alpha, 5e-5);
  EXPECT_NEAR(read[0].length, object.length, 5e-5);
  EXPECT_NEAR(read[0].x, object.x, 5e-5);
  EXPECT_NEAR(read[0].score, object.score, 5e-7);
}

TEST(KittiLabel, EmptyFilesHoldNoObjectsAndLineEndsDoNotMatter) {
  EXPECT_TRUE(parse_kitti_labels("", "t").empty());
  EXPECT_TRUE(parse_kitti_results("\n \r\n", "t").empty());
  std::string windows(kLabels);
  windows.insert(windows.find('\n'), "\r");
  windows.pop_back();
  EXPECT_EQ(format_kitti_labels(parse_kitti_labels(windows, "t")), kLabels);
}

TEST(KittiLabel, ResultsMayBePlaceholdersOfDetectionsInTheImage) {
  const auto objects =
      parse_kitti_results("Car -1.00 -1.00 -10 5 6 7 8 -1 -1 -1 -1000 -1000 -1000 -10 0.5\n", "t");
  EXPECT_FALSE(has_box(objects[0]));
  EXPECT_EQ(objects[0].score, 0.5);
}

TEST(KittiLabel, BadLinesAreRefusedWithFileLineExpectedAndCame) {
  const auto refused = [](const std::string& line, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_kitti_labels(kLabels + line, "label_2/7.txt"); }, parts);
  };
  const std::string place = "label_2/7.txt:3";
  refused("Car 0 0 0 1 2 3 4 1 1 1 1 1 1", {place, "15 fields", "got 14"});
  refused("Car 0 0 0 1 2 3 4 1 1 1 1 1 1 0 0.5", {place, "15 fields", "got 16"});
  refused("Car", {place, "15 fields", "got 1"});
  refused("Car 0 0 0 1 2 3 4 1 1 1 1 one 1 0", {place, "number as y", "'one'"});
  refused("Car 0 0 nan 1 2 3 4 1 1 1 1 1 1 0", {place, "finite number as alpha", "'nan'"});
  refused("Car 0 0 0 1 2 3 4 1 1 1 1 1 inf 0", {place, "finite number as z", "'inf'"});
  refused("Car 0 0 0 1 2 3 4 -1.5 1 1 1 1 1 0", {place, "size above zero as height", "-1.5"});
  refused("Car 0 0 0 1 2 3 4 1 0 1 1 1 1 0", {place, "size above zero as width", "got 0"});
  refused("Car 0 0 0 1 2 3 4 -1 -1 -1 1 1 1 0", {place, "size above zero as height"});
  refused("Car 1.5 0 0 1 2 3 4 1 1 1 1 1 1 0", {place, "truncation", "1.5"});
  refused("Car 0 4 0 1 2 3 4 1 1 1 1 1 1 0", {place, "occlusion", "4"});
  refused("Car 0 0.5 0 1 2 3 4 1 1 1 1 1 1 0", {place, "whole number as occlusion", "0.5"});
  refused("Car 0 1e300 0 1 2 3 4 1 1 1 1 1 1 0", {place, "occlusion"});
  refused("Car -1 0 0 1 2 3 4 1 1 1 1 1 1 0", {place, "truncation", "-1"});
  refused("Car 0 0 0 3 2 1 4 1 1 1 1 1 1 0", {place, "left <= right", "3 and 1"});
  refused("Car 0 0 0 1 4 3 2 1 1 1 1 1 1 0", {place, "top <= bottom", "4 and 2"});
  refused("Car 0 0 0 1 2 3 4 1 1 1 1 1 1 0x", {place, "'0x'"});
  refused(std::string("\0\xff\0", 3), {place, "15 fields"});
}

TEST(KittiLabel, BadResultsAreRefused) {
  const auto refused = [](const std::string& line, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_kitti_results(line, "r.txt"); }, parts);
  };
  refused("Car -1 -1 0 1 2 3 4 1 1 1 1 1 1 0", {"r.txt:1", "16 fields", "score", "got 15"});
  refused("Car -1 -1 0 1 2 3 4 1 1 1 1 1 1 0 nan", {"r.txt:1", "finite number as score"});
  refused("Car -1 -1 0 1 2 3 4 1 -1 1 1 1 1 0 0.5", {"r.txt:1", "size above zero as width"});
}

TEST(KittiLabel, DirectoriesAndMissingFilesAreRefused) {
  const arbox::testing::TemporaryDirectory folder;
  expect_refusal([&] { arbox::io::read_kitti_labels(folder.path()); }, {"directory"});
  expect_refusal([&] { arbox::io::read_kitti_results(folder / "no.txt"); }, {"no such file"});
}

TEST(KittiLabel, WriterRefusesWhatALineCannotHold) {
  KittiObject object{.type = "traffic cone"};
  expect_refusal([&] { format_kitti_results(std::vector{object}); }, {"'traffic cone'"});
  object.type = "";
  expect_refusal([&] { format_kitti_results(std::vector{object}); }, {"word"});
  object.type = "Car";
  object.x = std::numeric_limits<double>::quiet_NaN();
  expect_refusal([&] { format_kitti_labels(std::vector{object}); }, {"Car", "finite"});
}

}  // namespace
