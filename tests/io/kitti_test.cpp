#include "arbox/io/kitti.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "arbox/base/random.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_label.h"
#include "io/expect_refusal.h"
#include "io/made_calibration.h"
#include "support/program.h"

namespace {

using namespace arbox::io;
using arbox::geometry::Box;
using arbox::geometry::Detection;
using arbox::geometry::make_yaw_box;
using arbox::geometry::PointCloud;
using arbox::testing::expect_refusal;
using Eigen::Vector3d;

constexpr ImageSize kImage{1242, 375};

KittiCalibration made_calibration() {
  return parse_kitti_calibration(arbox::testing::kMadeCalibration, "made");
}

/// R0_rect is the identity and the LiDAR sits in the camera.
KittiCalibration plain_calibration() {
  KittiCalibration calibration;
  calibration.velodyne_to_camera.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  calibration.projections[2] = Projection::Zero();
  *calibration.projections[2] << 700, 0, 600, 0, 0, 700, 180, 0, 0, 0, 1, 0;
  return calibration;
}

Detection detection(const Box& box) {
  Detection result;
  result.label = "Car";
  result.score = 0.5;
  result.box = box;
  return result;
}

TEST(Kitti, AKnownObjectLandsWhereThePageSays) {
  const KittiObject object{.type = "Car",
                           .height = 1.5,
                           .width = 2,
                           .length = 4,
                           .x = 3,
                           .y = 1.7,
                           .z = 20,
                           .rotation_y = -std::numbers::pi / 2};
  const Box box = to_box(object, plain_calibration());
  EXPECT_TRUE(box.center.isApprox(Vector3d(20, -3, -1.7 + 0.75), 1e-12));
  EXPECT_EQ(box.size, Vector3d(4, 2, 1.5));
  EXPECT_NEAR(arbox::geometry::yaw(box), 0, 1e-15);
}

TEST(Kitti, BoxesGoToTheCameraAndBack) {
  const KittiCalibration calibration = made_calibration();
  for (std::uint64_t i = 0; i < 200; ++i) {
    const arbox::RandomStream random(5, i, 0);
    const Box box = make_yaw_box({50 * random.normal(0), 50 * random.normal(1), random.normal(2)},
                                 {random.uniform(3, 0.1, 9), random.uniform(4, 0.1, 9), 2},
                                 random.uniform(5, -3.14, 3.14));
    const KittiObject object = to_kitti_object(box, calibration);
    EXPECT_LE(std::abs(object.rotation_y), std::numbers::pi);
    const Box back = to_box(object, calibration);
    EXPECT_TRUE(back.center.isApprox(box.center, 1e-12));
    EXPECT_EQ(back.size, box.size);
    EXPECT_LT(back.rotation.angularDistance(box.rotation), 1e-7);
  }
}

TEST(Kitti, CornersOfTheObjectAreThoseOfItsBox) {
  // Without tilt between the frames both ways must give the same corners.
  const KittiCalibration calibration = plain_calibration();
  const Box box = make_yaw_box({12, 3, -1}, {4, 2, 1.5}, 0.7);
  const auto rect = rect_corners(to_kitti_object(box, calibration));
  for (const Vector3d& corner : arbox::geometry::corners(box)) {
    const Vector3d expected = calibration.rect_from_lidar() * corner;
    const auto same = [&](const Vector3d& p) { return (p - expected).norm() < 1e-12; };
    EXPECT_EQ(std::count_if(rect.begin(), rect.end(), same), 1) << expected.transpose();
  }
  EXPECT_GT(rect[0].y(), rect[4].y());
}

TEST(Kitti, TiltedInvalidAndMissingBoxesAreRefused) {
  Box box;
  box.rotation = Eigen::AngleAxisd(0.01, Vector3d::UnitX());
  expect_refusal([&] { to_kitti_object(box, made_calibration()); }, {"about z", "tilted"});
  box = {};
  box.size.x() = -1;
  expect_refusal([&] { to_kitti_object(box, made_calibration()); }, {"sizes"});
  expect_refusal([] { to_box({.type = "DontCare"}, made_calibration()); }, {"DontCare"});
}

TEST(Kitti, ProjectionIsThePinholeOfP2) {
  const Vector3d pixel = project({10, -2, 1}, plain_calibration());
  EXPECT_TRUE(pixel.isApprox(Vector3d(600 + 700 * 0.2, 180 - 700 * 0.1, 10), 1e-12));
  EXPECT_LT(project({-10, 0, 0}, plain_calibration()).z(), 0);
}

TEST(Kitti, ProjectedBoxSurroundsTheCornersAndIsCutBeforeTheCamera) {
  const KittiCalibration calibration = plain_calibration();
  const auto ahead = projected_box(
      to_kitti_object(make_yaw_box({10, 0, 0}, {2, 2, 2}, 0), calibration), calibration);
  ASSERT_TRUE(ahead);
  EXPECT_NEAR(ahead->left, 600 - 700.0 / 9, 1e-9);
  EXPECT_NEAR(ahead->bottom, 180 + 700.0 / 9, 1e-9);
  const auto beside = projected_box(
      to_kitti_object(make_yaw_box({0, -2, 0}, {4, 2, 1.5}, 0), calibration), calibration);
  ASSERT_TRUE(beside);
  EXPECT_GE(beside->left, 600);
  EXPECT_NEAR(beside->right, 600 + 700 * 3 / 0.1, 1e-6);
  EXPECT_FALSE(projected_box(to_kitti_object(make_yaw_box({-10, 0, 0}, {2, 2, 2}, 0), calibration),
                             calibration));
}

TEST(Kitti, ClippingKeepsTheImageAndDropsWhatIsOutside) {
  const auto cut = clipped({-5, 10, 2000, 380}, kImage);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->left, 0);
  EXPECT_EQ(cut->top, 10);
  EXPECT_EQ(cut->right, 1241);
  EXPECT_EQ(cut->bottom, 374);
  EXPECT_FALSE(clipped({-50, 10, -5, 20}, kImage));
  EXPECT_FALSE(clipped({10, 400, 20, 500}, kImage));
}

TEST(Kitti, ResultsHoldWhatTheImageShows) {
  const KittiCalibration calibration = plain_calibration();
  const std::vector detections = {detection(make_yaw_box({20, 5, -1}, {4, 2, 1.5}, 0.3)),
                                  detection(make_yaw_box({-20, 5, -1}, {4, 2, 1.5}, 0.3)),
                                  detection(make_yaw_box({2, 30, -1}, {4, 2, 1.5}, 0.3))};
  const auto results = to_kitti_results(detections, calibration, kImage);
  ASSERT_EQ(results.size(), 1u);
  const KittiObject& object = results[0];
  EXPECT_EQ(object.type, "Car");
  EXPECT_EQ(object.score, 0.5);
  EXPECT_EQ(object.truncation, -1);
  EXPECT_NEAR(object.alpha, -0.3 - std::numbers::pi / 2 - std::atan2(-5, 20), 1e-12);
  EXPECT_GT(object.right - object.left, 50);
  EXPECT_GT(object.left, 0);
  EXPECT_EQ(parse_kitti_results(format_kitti_results(results), "t").size(), 1u);
}

TEST(Kitti, ResultsWithoutACalibrationHaveTheDocumentedPlaceholders) {
  const std::vector detections = {detection(make_yaw_box({-20, 5, -1}, {4, 2, 1.5}, 0))};
  EXPECT_EQ(format_kitti_results(to_kitti_results(detections)),
            "Car -1 -1 -10 -1.0000 -1.0000 -1.0000 -1.0000 1.5000 2.0000 4.0000 -5.0000 1.7500 "
            "-20.0000 -1.5708 0.500000\n");
}

TEST(Kitti, FieldOfViewKeepsPointsOfTheImageWithTheirChannels) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const PointCloud cloud{
      .channels = {"intensity"},
      .values = {10, 0, 0, 0.5, -10, 0, 0, 0.6, 10, 9, 0, 0.7, nan, 0, 0, 0.8, 20, 1, -2, 0.9}};
  EXPECT_EQ(points_in_image(cloud.view(), plain_calibration(), kImage),
            (std::vector<std::size_t>{0, 4}));
  const PointCloud cropped = crop_to_image(cloud.view(), plain_calibration(), kImage);
  EXPECT_EQ(cropped.channels, cloud.channels);
  EXPECT_EQ(cropped.values, (std::vector<float>{10, 0, 0, 0.5, 20, 1, -2, 0.9}));
  EXPECT_TRUE(crop_to_image({}, plain_calibration(), kImage).values.empty());
}

TEST(KittiData, BoxesAndPointCountsAgreeWithOpenPcdet) {
  ARBOX_REQUIRE_DATA(training, "kitti/training");
  const auto infos = nlohmann::json::parse(
      read_file(training.parent_path() / "openpcdet_infos_000000-000005.json"));
  int compared = 0;
  for (const auto& info : infos) {
    const std::string id = info.at("frame");
    if (!std::filesystem::exists(training / "velodyne" / (id + ".bin"))) continue;
    const auto calibration = read_kitti_calibration(training / "calib" / (id + ".txt"));
    const auto labels = read_kitti_labels(training / "label_2" / (id + ".txt"));
    const std::string bytes = read_file(training / "velodyne" / (id + ".bin"));
    PointCloud cloud{.channels = {"intensity"}, .values = std::vector<float>(bytes.size() / 4)};
    std::memcpy(cloud.values.data(), bytes.data(), bytes.size());
    const ImageSize image{info.at("image_shape")[1], info.at("image_shape")[0]};
    const PointCloud seen = crop_to_image(cloud.view(), calibration, image);
    EXPECT_EQ(known_image_size(calibration), image) << id;
    const auto& boxes = info.at("gt_boxes_lidar");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      SCOPED_TRACE(id + " " + labels.at(i).type);
      const Box box = to_box(labels.at(i), calibration);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(box.center[axis], boxes[i][axis].get<double>(), 1e-4);
        EXPECT_NEAR(box.size[axis], boxes[i][3 + axis].get<double>(), 1e-6);
      }
      const double turn = arbox::geometry::yaw(box) - boxes[i][6].get<double>();
      EXPECT_NEAR(arbox::geometry::wrap_angle(turn), 0, 1e-6);
      int count = 0;
      for (std::size_t k = 0; k < seen.size(); ++k) {
        count += contains(box, seen.view().position(k).cast<double>());
      }
      EXPECT_NEAR(count, info.at("num_points_in_gt")[i].get<int>(), 7);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 8);
}

}  // namespace
