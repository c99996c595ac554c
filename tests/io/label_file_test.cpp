#include "arbox/io/label_file.h"

#include <gtest/gtest.h>

#include "arbox/io/arbox_dataset.h"
#include "arbox/io/detection_json.h"
#include "io/expect_refusal.h"

namespace arbox {
namespace {

using io::parse_label_json;
using io::parse_label_text;
using testing::expect_refusal;

TEST(LabelFile, TextHoldsOneBoxALine) {
  const auto file = parse_label_text("# made\n\n1 2 3 4 2 1.5 7 Car\r\n-1 0 0 1 1 1 0 dog\n", "t");
  ASSERT_EQ(file.objects.size(), 2u);
  EXPECT_EQ(file.objects[0].label, "Car");
  EXPECT_EQ(file.objects[0].box.size, Eigen::Vector3d(4, 2, 1.5));
  EXPECT_EQ(file.objects[0].written_yaw, 7.0);
  EXPECT_NEAR(geometry::yaw(file.objects[0].box), 7.0 - 2 * 3.14159265358979, 1e-9);
  EXPECT_TRUE(parse_label_text("", "t").objects.empty());
}

TEST(LabelFile, JsonRoundTrips) {
  std::vector<io::LabeledObject> objects = {
      {.label = "box \"a\"",
       .box = {.center = {1, 2, 3},
               .size = {0.1, 0.2, 0.3},
               .rotation = geometry::Quaternion(0.5, 0.5, -0.5, 0.5)},
       .heading = io::Heading::kHalfKnown,
       .attributes = {{"id", 7}, {"visible", 0.25}}},
      {.label = "Car", .box = geometry::make_yaw_box({0, 0, 0}, {4, 2, 1}, 0.3)}};
  const auto file = parse_label_json(io::format_label_json(objects, io::SceneFrame::kCamera), "t");
  EXPECT_EQ(file.frame, io::SceneFrame::kCamera);
  ASSERT_EQ(file.objects.size(), 2u);
  EXPECT_EQ(file.objects[0].label, objects[0].label);
  EXPECT_EQ(file.objects[0].box.rotation.coeffs(), objects[0].box.rotation.coeffs());
  EXPECT_EQ(file.objects[0].heading, io::Heading::kHalfKnown);
  EXPECT_EQ(file.objects[0].attributes, objects[0].attributes);
  EXPECT_EQ(file.objects[1].box.size, objects[1].box.size);
  EXPECT_TRUE(
      parse_label_json(io::format_label_json({}, io::SceneFrame::kRoom), "t").objects.empty());
}

TEST(LabelFile, WhatDetectWroteIsALabelFile) {
  io::ScanDetections scan{.source = "a.bin", .frame = "lidar"};
  scan.detections.emplace_back().label = "Car";
  const auto file = parse_label_json(io::format_detections_json(scan), "t");
  ASSERT_EQ(file.objects.size(), 1u);
  EXPECT_EQ(file.objects[0].label, "Car");
}

TEST(LabelFile, RefusesWithPlaceAndMend) {
  expect_refusal([] { parse_label_text("1 2 3 4 2 1.5 Car\n", "t"); }, {"t:1", "8 fields", "7"});
  expect_refusal([] { parse_label_text("1 2 3 4 0 1.5 0 Car\n", "t"); }, {"width", "'0'"});
  expect_refusal([] { parse_label_text("1 2 nan 4 2 1.5 0 Car\n", "t"); }, {"t:1", "z", "nan"});
  expect_refusal([] { parse_label_text("Car 0 0 0 1 2 3 4 1.5 1.7 4.2 -2 1.7 20 1.1\n", "t"); },
                 {"15 fields", "KITTI"});
  expect_refusal([] { parse_label_json("[]", "t"); }, {"t", "objects"});
  expect_refusal([] { parse_label_json(R"({"objects": [{"class": "a"}]})", "t"); },
                 {"t: /objects/0", "box"});
  expect_refusal([] { parse_label_json(R"({"objects": [], "frame": "moon"})", "t"); },
                 {"/frame", "lidar, room, camera", "moon"});
}

TEST(DatasetDescription, RoundTripsAndRefusesUnknownKeys) {
  io::DatasetDescription description{.frame = io::SceneFrame::kRoom, .classes = {"a", "b"}};
  description.class_map = {{"x", "a"}, {"y", std::nullopt}};
  description.columns = {"x", "y", "z"};
  const auto again =
      io::parse_dataset_description(io::format_dataset_description(description), "d");
  EXPECT_EQ(again.frame, description.frame);
  EXPECT_EQ(again.classes, description.classes);
  EXPECT_EQ(again.class_map, description.class_map);
  EXPECT_EQ(again.columns, description.columns);
  expect_refusal(
      [] {
        io::parse_dataset_description(R"({"format": "arbox dataset", "version": 1, "clases": []})",
                                      "d");
      },
      {"d", "classes", "clases"});
  expect_refusal([] { io::parse_dataset_description(R"({"format": "x", "version": 1})", "d"); },
                 {"/format", "arbox dataset"});
}

TEST(CameraFile, RoundTrips) {
  io::CameraFile camera{.size = {640, 480}};
  camera.projection << 500, 1, 320, 4, 0, 500, 240, 5, 0, 0, 1, 0.1;
  const auto again = io::parse_camera_json(io::format_camera_json(camera), "c");
  EXPECT_EQ(again.projection, camera.projection);
  EXPECT_EQ(again.size, camera.size);
  expect_refusal([] { io::parse_camera_json(R"({"projection": [[1, 2, 3]]})", "c"); },
                 {"c: /projection", "three rows"});
}

}  // namespace
}  // namespace arbox
