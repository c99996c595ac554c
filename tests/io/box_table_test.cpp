#include "arbox/io/box_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "arbox/base/random.h"
#include "arbox/io/file.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace {

using arbox::geometry::Box;
using arbox::io::BoxTable;
using arbox::io::format_box_table;
using arbox::io::parse_box_table;
using arbox::testing::expect_refusal;

constexpr double kHalfTurn = std::numbers::sqrt2 / 2;

TEST(BoxTable, SevenColumnsAreAYawBox) {
  const BoxTable table = parse_box_table("1,2,3,4,5,6,1.5\n-1,-2,-3,4,5,6,-3\n", "t.csv");
  ASSERT_EQ(table.boxes.size(), 2u);
  EXPECT_EQ(table.boxes[0].center, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(table.boxes[0].size, Eigen::Vector3d(4, 5, 6));
  EXPECT_NEAR(arbox::geometry::yaw(table.boxes[0]), 1.5, 1e-15);
  EXPECT_NEAR(arbox::geometry::yaw(table.boxes[1]), -3, 1e-15);
  EXPECT_TRUE(table.objects.empty() && table.scores.empty() && table.classes.empty());
}

TEST(BoxTable, TenColumnsAreAQuaternionBoxThatIsNormalised) {
  const BoxTable table = parse_box_table("1 2 3 4 5 6 1.0009 0 0 0\n0 0 0 1 1 1 0 0 0 -1", "t");
  ASSERT_EQ(table.boxes.size(), 2u);
  EXPECT_DOUBLE_EQ(table.boxes[0].rotation.w(), 1.0);
  EXPECT_DOUBLE_EQ(table.boxes[1].rotation.z(), -1.0);
}

TEST(BoxTable, EverySeparatorLineEndAndHeaderFormReadsTheSame) {
  const std::string expected = format_box_table(parse_box_table("1,2,3,4,5,6,0.5\n", "t"));
  for (const char* text : {"1;2;3;4;5;6;0.5\n", "1\t2\t3\t4\t5\t6\t0.5", "  1  2 3 4 5 6 0.5  \r\n",
                           "1, 2, 3, 4, 5, 6, +0.5\n\n", "x,y,z,l,w,h,yaw\n1,2,3,4,5,6,0.5\n",
                           "# x y z l w h yaw\n1 2 3 4 5 6 5e-1\n",
                           "\xef\xbb\xbfx;y;z;l;w;h;yaw\r\n1;2;3;4;5;6;.5\r\n",
                           "yaw,h,w,l,z,y,x\n0.5,6,5,4,3,2,1\n"}) {
    EXPECT_EQ(format_box_table(parse_box_table(text, "t")), expected) << text;
  }
}

TEST(BoxTable, HeaderNamesExtraColumnsInAnyOrder) {
  const BoxTable table = parse_box_table(
      "class,qz,qy,qx,qw,score,object,h,w,l,z,y,x\n"
      "\"Delivery, \"\"big\"\" van\",0,0,0,1,0.25,7,6,5,4,3,2,1\n",
      "t");
  EXPECT_EQ(table.classes, std::vector<std::string>{"Delivery, \"big\" van"});
  EXPECT_EQ(table.scores, std::vector<double>{0.25});
  EXPECT_EQ(table.objects, std::vector<std::int64_t>{7});
  EXPECT_EQ(table.boxes[0].center, Eigen::Vector3d(1, 2, 3));
}

TEST(BoxTable, OptionsSayWhatAFileWithoutAHeaderMayHave) {
  const BoxTable sample = parse_box_table("3,1,2,3,4,5,6,0\n", "t", {.object = true});
  EXPECT_EQ(sample.objects, std::vector<std::int64_t>{3});
  const BoxTable plain = parse_box_table("1,2,3,4,5,6,0\n", "t", {.object = true});
  EXPECT_TRUE(plain.objects.empty());
  const BoxTable scored =
      parse_box_table("1,2,3,4,5,6,0,0.5,Car\n", "t", {.score = true, .class_name = true});
  EXPECT_EQ(scored.scores, std::vector<double>{0.5});
  EXPECT_EQ(scored.classes, std::vector<std::string>{"Car"});
  const BoxTable swapped =
      parse_box_table("1,2,3,4,5,6,0,Car,0.5\n", "t", {.score = true, .class_name = true});
  EXPECT_EQ(swapped.classes, std::vector<std::string>{"Car"});
  EXPECT_EQ(parse_box_table("5,1,2,3,4,5,6,1,0,0,0\n", "t", {.object = true}).objects,
            std::vector<std::int64_t>{5});
  expect_refusal([] { parse_box_table("1,2,3,4,5,6,7,8\n", "t", {.object = true, .score = true}); },
                 {"t:1", "header", "object x y z l w h yaw", "x y z l w h yaw score"});
}

TEST(BoxTable, EmptyFilesHoldNoBoxes) {
  for (const char* text : {"", "\n", " \r\n\n", "x,y,z,l,w,h,yaw", "x,y,z,l,w,h,qw,qx,qy,qz\n"}) {
    EXPECT_TRUE(parse_box_table(text, "t").boxes.empty()) << text;
  }
}

TEST(BoxTable, BadRowsAreRefusedWithFileLineExpectedAndCame) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_box_table(text, "boxes.csv"); }, parts);
  };
  refused("1,2,3,4,5,6\n", {"boxes.csv:1", "x y z l w h yaw", "got 6 fields"});
  refused("1,2,3,4,5,6,7,8\n", {"boxes.csv:1", "got 8 fields"});
  refused("1,2,3,4,5,6,0\n1,2,3,4,5,6\n", {"boxes.csv:2", "7 fields", "got 6"});
  refused("1,2,3,4,5,6,0\n1,2,3,4,5,6,1,0,0,0\n", {"boxes.csv:2", "7 fields", "got 10"});
  refused("1,2,3,4,5,6,0,\n", {"boxes.csv:1", "got 8 fields"});
  refused("1,2,,4,5,6,0\n", {"boxes.csv:1", "number as z", "''"});
  refused("1,2,3,4,5,6,abc\n", {"boxes.csv:1", "number as yaw", "'abc'"});
  refused("\n\n1,2,3,4,5,6,0\n1,2,3,4,5,6x,0\n", {"boxes.csv:4", "number as h", "'6x'"});
  refused("1,nan,3,4,5,6,0\n", {"finite number as y", "'nan'"});
  refused("1,2,inf,4,5,6,0\n", {"finite number as z", "'inf'"});
  refused("1,2,1e999,4,5,6,0\n", {"finite number as z", "'1e999'"});
  refused("1,2,3,0,5,6,0\n", {"size above zero as l", "'0'"});
  refused("1,2,3,4,-5,6,0\n", {"size above zero as w", "'-5'"});
  refused("1,2,3,4,5,6,0.9,0,0,0\n", {"unit quaternion", "norm 0.9"});
  refused("1,2,3,4,5,6,0,0,0,0\n", {"unit quaternion", "norm 0"});
  refused("1,2,3,4,5,6,1e200,1e200,0,0\n", {"unit quaternion"});
  refused("x,y,z,l,w,h,heading\n", {"boxes.csv:1", "yaw or qw", "'heading'"});
  refused("x,y,z,l,w,h\n", {"no column 'yaw'"});
  refused("x,y,z,l,w,h,qw,qx,qy\n", {"no column 'qz'"});
  refused("x,y,z,l,w,h,qw,qx,qy,qz,yaw\n", {"yaw or a quaternion", "both"});
  refused("x,y,z,l,w,h,yaw,x\n", {"each column once", "'x' twice"});
  refused("object,x,y,z,l,w,h,yaw\n1.5,1,2,3,4,5,6,0\n", {"boxes.csv:2", "whole number", "'1.5'"});
  refused(std::string("1,2,3,4,5,6,\0\n", 14), {"'\\x00'"});
}

TEST(BoxTable, DirectoriesAndMissingFilesAreRefused) {
  expect_refusal([] { arbox::io::read_box_table(std::filesystem::temp_directory_path()); },
                 {"directory"});
  expect_refusal([] { arbox::io::read_box_table("/nonexistent/boxes.csv"); }, {"no such file"});
}

TEST(BoxTable, WhatIsWrittenReadsBackAsTheSameDoubles) {
  for (const bool free_rotation : {false, true}) {
    BoxTable table;
    for (int i = 0; i < 200; ++i) {
      const arbox::RandomStream random(17, i, free_rotation);
      Box box;
      for (int axis = 0; axis < 3; ++axis) {
        box.center[axis] = 1e3 * random.normal(axis);
        box.size[axis] = std::exp(random.normal(3 + axis));
      }
      box.rotation = {random.normal(6), 0, 0, random.normal(7)};
      if (free_rotation) box.rotation.x() = random.normal(8);
      box.rotation.normalize();
      table.boxes.push_back(box);
      table.objects.push_back(i / 3 - 5);
      table.scores.push_back(random.uniform(9));
      table.classes.emplace_back(i % 2 ? "Car" : "parked \"old\" car; red, rusty");
    }
    const arbox::testing::TemporaryDirectory folder;
    const auto path = folder / "boxes.csv";
    arbox::io::write_box_table(path, table);
    const BoxTable read = arbox::io::read_box_table(path);
    ASSERT_EQ(read.boxes.size(), table.boxes.size());
    for (std::size_t i = 0; i < table.boxes.size(); ++i) {
      EXPECT_EQ(read.boxes[i].center, table.boxes[i].center);
      EXPECT_EQ(read.boxes[i].size, table.boxes[i].size);
      EXPECT_NEAR(read.boxes[i].rotation.angularDistance(table.boxes[i].rotation), 0, 1e-7);
      if (free_rotation) {
        EXPECT_TRUE(read.boxes[i].rotation.isApprox(table.boxes[i].rotation, 1e-15));
      }
    }
    EXPECT_EQ(read.objects, table.objects);
    EXPECT_EQ(read.scores, table.scores);
    EXPECT_EQ(read.classes, table.classes);
  }
}

TEST(BoxTable, WriterRefusesInvalidBoxesAndUnequalColumns) {
  BoxTable table;
  table.boxes.resize(2);
  table.scores = {0.5};
  expect_refusal([&] { format_box_table(table); }, {"score", "1 entries", "2 boxes"});
  table.scores.clear();
  table.boxes[1].size.x() = -1;
  expect_refusal([&] { format_box_table(table); }, {"row 1", "sizes"});
}

TEST(BoxTable, DetectionsBecomeRowsWithClassAndScore) {
  arbox::geometry::Detection detection;
  detection.label = "Cyclist";
  detection.score = 0.75;
  detection.box = arbox::geometry::make_yaw_box({1, 2, 3}, {2, 1, 1.5}, kHalfTurn);
  const BoxTable table = arbox::io::to_box_table(std::vector{detection, detection});
  EXPECT_EQ(table.classes, (std::vector<std::string>{"Cyclist", "Cyclist"}));
  EXPECT_EQ(format_box_table(table).substr(0, 31), "x,y,z,l,w,h,yaw,score,class\n1,2");
}

}  // namespace
