#include "arbox/io/kitti_calibration.h"

#include <gtest/gtest.h>

#include "io/expect_refusal.h"
#include "io/made_calibration.h"
#include "support/program.h"

namespace {

using arbox::io::ImageSize;
using arbox::io::KittiCalibration;
using arbox::io::KittiPlane;
using arbox::io::parse_kitti_calibration;
using arbox::io::parse_kitti_plane;
using arbox::testing::expect_refusal;
using arbox::testing::kMadeCalibration;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(KittiCalibration, MatricesAreReadByName) {
  const KittiCalibration calibration = parse_kitti_calibration(kMadeCalibration, "t");
  EXPECT_EQ(calibration.p2()(0, 3), 40);
  EXPECT_EQ(calibration.p2()(2, 3), 0.005);
  EXPECT_EQ(calibration.r0_rect(0, 2), 0.28);
  EXPECT_EQ(calibration.velodyne_to_camera.translation().z(), -0.27);
  EXPECT_EQ((*calibration.projections[3])(1, 3), 2);
  EXPECT_EQ(calibration.imu_to_velodyne->translation().x(), -0.8);
}

TEST(KittiCalibration, TheOrderOfLinesDoesNotMatter) {
  std::string turned;
  std::istringstream lines(kMadeCalibration);
  for (std::string line; std::getline(lines, line);) turned = "\r\n" + line + "\r\n" + turned;
  const auto a = parse_kitti_calibration(kMadeCalibration, "t");
  const auto b = parse_kitti_calibration("calib_time: 09-Jan-2012 13:57:47\n" + turned, "t");
  EXPECT_EQ(format_kitti_calibration(a), format_kitti_calibration(b));
}

TEST(KittiCalibration, NamesOfTheTrackingBenchmarkAreKnown) {
  std::string text = replaced(kMadeCalibration, "R0_rect:", "R_rect");
  text = replaced(text, "Tr_velo_to_cam:", "Tr_velo_cam");
  EXPECT_EQ(parse_kitti_calibration(text, "t").r0_rect(0, 2), 0.28);
}

TEST(KittiCalibration, WhatIsWrittenReadsBack) {
  const auto a = parse_kitti_calibration(kMadeCalibration, "t");
  const auto b = parse_kitti_calibration(format_kitti_calibration(a), "t");
  EXPECT_EQ(a.p2(), b.p2());
  EXPECT_EQ(a.r0_rect, b.r0_rect);
  EXPECT_EQ(a.velodyne_to_camera.matrix(), b.velodyne_to_camera.matrix());
  EXPECT_TRUE(b.imu_to_velodyne && b.projections[0] && b.projections[1] && b.projections[3]);
}

TEST(KittiCalibration, TransformsBetweenLidarAndCameraAreInverse) {
  const auto calibration = parse_kitti_calibration(kMadeCalibration, "t");
  const Eigen::Vector3d point(10, -2, 0.5);
  const Eigen::Vector3d rect = calibration.rect_from_lidar() * point;
  const Eigen::Vector3d camera(2 + 0.01, -0.5 - 0.08, 10 - 0.27);
  EXPECT_TRUE(rect.isApprox(Eigen::Vector3d(0.96 * camera.x() + 0.28 * camera.z(), camera.y(),
                                            -0.28 * camera.x() + 0.96 * camera.z()),
                            1e-12));
  EXPECT_TRUE((calibration.lidar_from_rect() * rect).isApprox(point, 1e-12));
}

TEST(KittiCalibration, BadFilesAreRefusedWithFileLineExpectedAndCame) {
  const auto refused = [](const std::string& from, const std::string& to,
                          const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_kitti_calibration(replaced(kMadeCalibration, from, to), "c.txt"); },
                   parts);
  };
  expect_refusal([] { parse_kitti_calibration("", "c.txt"); }, {"c.txt", "'P2: ...'", "none"});
  refused("P2:", "P4:", {"c.txt", "'P2: ...'", "R0_rect"});
  refused("R0_rect:", "R1_rect:", {"c.txt", "'R0_rect: ...'"});
  refused("Tr_velo_to_cam:", "Tr_velo:", {"c.txt", "'Tr_velo_to_cam: ...'"});
  refused("P3:", "P2:", {"c.txt:4", "once", "'P2' twice"});
  refused(" 0 0 1 0.005", " 0 0 1", {"c.txt:3", "12 numbers after P2", "got 11"});
  refused("-0.28 0 0.96\n", "-0.28 0 0.96 0 0 1\n", {"c.txt:5", "9 numbers", "got 12"});
  refused("0.01", "0.01x", {"c.txt:6", "Tr_velo_to_cam", "'0.01x'"});
  refused("0.01", "nan", {"c.txt:6", "finite number", "'nan'"});
  refused("R0_rect: 0.96", "R0_rect: 0.9", {"c.txt:5", "rotation matrix as R0_rect"});
  refused("0 0 -1 -0.08", "0 0 1 -0.08",
          {"c.txt:6", "rotation matrix as Tr_velo_to_cam", "determinant -1"});
  refused("0 0 -1 -0.08", "0 0 0 -0.08", {"c.txt:6", "rotation matrix", "determinant 0"});
  refused("Tr_imu_to_velo: 1", "Tr_imu_to_velo: 2", {"c.txt:7", "rotation matrix as Tr_imu"});
  refused("P2: 700", "P2: 0", {"c.txt:3", "invertible", "singular"});
  const arbox::testing::TemporaryDirectory folder;
  expect_refusal([&] { arbox::io::read_kitti_calibration(folder.path()); }, {"directory"});
}

TEST(KittiCalibration, EveryTruncationIsRefusedOrStillWhole) {
  const std::size_t imu = kMadeCalibration.find("Tr_imu");
  const std::size_t last_number = kMadeCalibration.find("-0.27");
  for (std::size_t length = 0; length < last_number; ++length) {
    EXPECT_THROW(parse_kitti_calibration(kMadeCalibration.substr(0, length), "t"),
                 arbox::FormatError)
        << length;
  }
  EXPECT_NO_THROW(parse_kitti_calibration(kMadeCalibration.substr(0, imu), "t"));
}

TEST(KittiCalibration, ImageSizesOfTheRecordingDaysAreKnown) {
  std::string text = kMadeCalibration;
  EXPECT_FALSE(known_image_size(parse_kitti_calibration(text, "t")));
  text = replaced(text, "P2: 700 0 600", "P2: 7.215377e+02 0 6.095593e+02");
  EXPECT_EQ(known_image_size(parse_kitti_calibration(text, "t")), (ImageSize{1242, 375}));
}

TEST(KittiPlane, IsNormalisedAndTurnedUp) {
  const KittiPlane plane = parse_kitti_plane("# Matrix\nWIDTH 4\nHEIGHT 1\n0 2 0 -3.3 \n", "t");
  EXPECT_TRUE(plane.normal.isApprox(Eigen::Vector3d(0, -1, 0)));
  EXPECT_DOUBLE_EQ(plane.offset, 1.65);
}

TEST(KittiPlane, InLidarKeepsTheDistancesOfPoints) {
  const auto calibration = parse_kitti_calibration(kMadeCalibration, "t");
  const KittiPlane plane = parse_kitti_plane("0.1 -1 0.05 1.6\n", "t");
  const KittiPlane lidar = plane_in_lidar(plane, calibration);
  EXPECT_GT(lidar.normal.z(), 0.9);
  const Eigen::Vector3d point(12, 3, -1);
  EXPECT_NEAR(lidar.normal.dot(point) + lidar.offset,
              plane.normal.dot(calibration.rect_from_lidar() * point) + plane.offset, 1e-12);
}

TEST(KittiPlane, BadFilesAreRefused) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_kitti_plane(text, "p.txt"); }, parts);
  };
  refused("", {"p.txt", "four numbers", "none"});
  refused("# Matrix\nWIDTH 4\nHEIGHT 1\n", {"p.txt", "four numbers", "none"});
  refused("WIDTH 3\n", {"p.txt:1", "WIDTH 4", "'3'"});
  refused("HEIGHT 2\n", {"p.txt:1", "HEIGHT 1", "'2'"});
  refused("0 -1 0\n", {"p.txt:1", "four numbers", "3 fields"});
  refused("0 -1 0 nan\n", {"p.txt:1", "finite", "'nan'"});
  refused("0 0 0 1\n", {"p.txt:1", "not zero"});
  refused("0 -1 0 1\n0 -1 0 1\n", {"p.txt:2", "one plane"});
}

}  // namespace
