#include "arbox/io/annotation_tools.h"

#include <gtest/gtest.h>

#include <cmath>

#include "arbox/geometry/rotation.h"
#include "arbox/io/dataset.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox {
namespace {

using io::AngleUnit;
using io::parse_cvat_tracklets;
using io::parse_labelcloud_json;
using testing::expect_refusal;
using testing::TemporaryDirectory;

std::string centroid(const std::string& angle) {
  return R"({"folder": "pointclouds", "filename": "a.pcd", "path": "pointclouds/a.pcd", "objects": [
    {"name": "cart", "centroid": {"x": 1, "y": 2, "z": 3},
     "dimensions": {"length": 4, "width": 2, "height": 1},
     "rotations": {"x": 0, "y": 0, "z": )" +
         angle + "}}]}";
}

TEST(LabelCloud, CentroidsInDegreesAndRadians) {
  const auto degrees = parse_labelcloud_json(centroid("270"), "l", AngleUnit::kDegrees);
  const auto radians =
      parse_labelcloud_json(centroid("-1.5707963267948966"), "l", AngleUnit::kRadians);
  EXPECT_EQ(degrees.cloud, "a.pcd");
  EXPECT_EQ(degrees.largest_angle, 270.0);
  EXPECT_EQ(degrees.objects[0].box.size, Eigen::Vector3d(4, 2, 1));
  EXPECT_NEAR(geometry::yaw(degrees.objects[0].box), -M_PI / 2, 1e-12);
  EXPECT_NEAR(
      geometry::rotation_distance(degrees.objects[0].box.rotation, radians.objects[0].box.rotation),
      0, 1e-7);
}

TEST(LabelCloud, VerticesGiveTheSameBox) {
  const geometry::Box box{
      .center = {1, 2, 3},
      .size = {4, 2, 1},
      .rotation = geometry::to_quaternion(geometry::RollPitchYaw{0.1, -0.2, 0.7})};
  // Low or high along length, width and height, in labelCloud's order.
  const int signs[8][3] = {{-1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {1, -1, -1},
                           {-1, -1, 1},  {-1, 1, 1},  {1, 1, 1},  {1, -1, 1}};
  std::string text = R"({"objects": [{"name": "a", "vertices": [)";
  for (const auto& sign : signs) {
    const Eigen::Vector3d half(sign[0] * 2.0, sign[1] * 1.0, sign[2] * 0.5);
    const Eigen::Vector3d v = box.center + box.rotation * half;
    text += (text.back() == '[' ? "[" : ",[") + std::to_string(v.x()) + "," +
            std::to_string(v.y()) + "," + std::to_string(v.z()) + "]";
  }
  const auto file = parse_labelcloud_json(text + "]}]}", "l", AngleUnit::kDegrees);
  EXPECT_LE((file.objects[0].box.size - box.size).norm(), 1e-5);
  EXPECT_LE(geometry::rotation_distance(file.objects[0].box.rotation, box.rotation), 1e-5);
}

TEST(LabelCloud, FoldersTellTheUnitOfTheirAngles) {
  for (const auto& [angle, yaw] : {std::pair{"90", M_PI / 2}, std::pair{"1.5", 1.5}}) {
    const TemporaryDirectory folder;
    folder.write("pointclouds/a.xyz", "1 2 3\n");
    folder.write("pointclouds/b.xyz", "1 2 3\n");
    folder.write("labels/a.json", centroid(angle));
    folder.write("labels/_classes.json", "{}");
    const auto dataset = io::open_dataset(folder.path());
    EXPECT_EQ(dataset->layout(), "labelcloud");
    EXPECT_NEAR(geometry::yaw(dataset->load("all", "a").objects[0].box), yaw, 1e-9);
    EXPECT_FALSE(dataset->load("all", "b").labelled);
    const auto told = io::open_dataset(folder.path(), {.angles = "degrees"});
    EXPECT_NEAR(geometry::yaw(told->load("all", "a").objects[0].box), std::stod(angle) * M_PI / 180,
                1e-9);
  }
}

TEST(LabelCloud, UntransformedKittiLinesStandInTheCloudsFrame) {
  const TemporaryDirectory folder;
  folder.write("pointclouds/a.xyz", "1 2 3\n");
  folder.write("labels/a.txt", "cart 0 0 0 0 0 0 0 1 2 4 1 2 3 0.5\n");
  const auto scene = io::open_dataset(folder.path())->load("all", "a");
  EXPECT_EQ(scene.objects[0].box.center, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.objects[0].box.size, Eigen::Vector3d(4, 2, 1));
  EXPECT_NEAR(geometry::yaw(scene.objects[0].box), 0.5, 1e-12);
}

constexpr const char* kTracklets = R"(<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<!DOCTYPE boost_serialization>
<boost_serialization version="9" signature="serialization::archive">
<tracklets version="0" tracking_level="0" class_id="0">
  <count>1</count><item_version>1</item_version>
  <item version="1" tracking_level="0" class_id="1">
    <objectType>car</objectType><h>1.8</h><w>4.2</w><l>1.5</l><first_frame>1</first_frame>
    <poses version="0" tracking_level="0" class_id="2"><count>2</count><item_version>2</item_version>
      <item version="1" tracking_level="0" class_id="3"><tx>1</tx><ty>2</ty><tz>-0.5</tz>
        <rx>0</rx><ry>0</ry><rz>0.3</rz><state>2</state><occlusion>0</occlusion>
        <occlusion_kf>0</occlusion_kf><truncation>0</truncation></item>
      <item><tx>1</tx><ty>2</ty><tz>0</tz><rx>0</rx><ry>0</ry><rz>0</rz><truncation>TruncationStates.OUT_IMAGE</truncation></item>
      <item><tx>5</tx><ty>2</ty><tz>0</tz><rx>0</rx><ry>0</ry><rz>0</rz><truncation>0</truncation></item>
    </poses><finished>1</finished>
  </item>
</tracklets>
</boost_serialization>)";

TEST(Cvat, ExtentsAreThoseAlongTheBoxesAxes) {
  const auto tracklets = parse_cvat_tracklets(kTracklets, "t");
  ASSERT_EQ(tracklets.size(), 2u);
  const auto& object = tracklets.at(1).at(0);
  EXPECT_EQ(object.label, "car");
  EXPECT_EQ(object.box.size, Eigen::Vector3d(4.2, 1.8, 1.5));
  EXPECT_EQ(object.box.center, Eigen::Vector3d(1, 2, -0.5));
  EXPECT_NEAR(geometry::yaw(object.box), 0.3, 1e-12);
  EXPECT_EQ(tracklets.at(3).at(0).box.center.x(), 5.0);
}

TEST(Cvat, FramesFindTheirClouds) {
  const TemporaryDirectory folder;
  folder.write("tracklet_labels.xml", kTracklets);
  folder.write("frame_list.txt", "0 a\n1 sub/b\n");
  folder.write("velodyne_points/data/a.xyz", "1 2 3\n");
  folder.write("velodyne_points/data/b.xyz", "1 2 3\n");
  const auto dataset = io::open_dataset(folder.path());
  EXPECT_EQ(dataset->layout(), "cvat");
  EXPECT_TRUE(dataset->load("all", "a").objects.empty());
  EXPECT_EQ(dataset->load("all", "b").objects.size(), 1u);
  ASSERT_EQ(dataset->problems().size(), 1u);
  EXPECT_NE(dataset->problems()[0].find("frame 3"), std::string::npos);
}

TEST(AnnotationTools, RefuseWhatIsWrong) {
  expect_refusal([] { parse_labelcloud_json("{}", "l", AngleUnit::kDegrees); }, {"objects"});
  expect_refusal(
      [] {
        parse_labelcloud_json(R"({"objects": [{"name": "a", "vertices": [[1,2,3]]}]})", "l",
                              AngleUnit::kDegrees);
      },
      {"/objects/0/vertices", "eight"});
  expect_refusal([] { parse_cvat_tracklets("<a>", "t"); }, {"t:", "XML"});
  expect_refusal([] { parse_cvat_tracklets("<a></a>", "t"); }, {"tracklets"});
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  expect_refusal([&] { parse_cvat_tracklets(deep, "t"); }, {"nested"});
}

}  // namespace
}  // namespace arbox
