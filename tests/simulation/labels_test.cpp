#include "arbox/simulation/labels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/kitti.h"
#include "arbox/simulation/lidar_scan.h"
#include "arbox/simulation/models.h"
#include "arbox/simulation/street_stream.h"
#include "simulation/placed_model.h"
#include "simulation/resting_street.h"

namespace arbox::simulation {
namespace {

/// A return in the frame of a box, as distances beyond its faces (negative: inside).
Eigen::Vector3d beyond(const geometry::Box& box, const LidarReturn& point) {
  const Eigen::Vector3d local =
      box.rotation.conjugate() * (Eigen::Vector3d(point.x, point.y, point.z) - box.center);
  return local.cwiseAbs() - 0.5 * box.size;
}

TEST(Labels, ReturnsOfAnObjectLieInItsBox) {
  std::int64_t returns = 0, mirrors = 0;
  for (std::uint64_t index = 0; index < 6; ++index) {
    const Scene scene = resting_street(11, index);
    const LidarModel model = hdl64();
    for (const LidarReturn& point : scan(scene, RayTracer(scene, model.duration), model,
                                         {.motion_compensated = false, .ideal = true})) {
      if (point.object < 0) continue;
      const SceneObject& object = scene.objects[point.object];
      const Eigen::Vector3d out = beyond(object.box, point);
      ++returns;
      ASSERT_LT(out.x(), 0.01) << object.label;
      ASSERT_LT(out.z(), 0.01) << object.label;
      ASSERT_LT(out.y(), 1.4 * kMirrorOverhang + 0.01) << object.label;
      mirrors += out.y() > 0.01;
    }
  }
  EXPECT_GT(returns, 10000);
  EXPECT_LT(mirrors, returns / 100);
}

/// Whether returns lie in the boxes that a scan shows. Left out are objects near by, which take
/// much of the turn, and those in the seam behind the scanner, of which a scan shows two halves.
void expect_returns_in_scanned_boxes(bool compensated) {
  std::int64_t returns = 0, outside = 0, outside_at_rest = 0;
  for (std::uint64_t index = 0; index < 8; ++index) {
    const Scene scene = street_scene({}, 12, index);
    const LidarModel model = hdl64();
    const LidarOptions options{.motion_compensated = compensated, .ideal = true};
    const auto boxes = scanned_boxes(scene, model, options);
    for (const LidarReturn& point : scan(scene, RayTracer(scene, model.duration), model, options)) {
      if (point.object < 0 || std::hypot(point.x, point.y) < 8.0 ||
          std::abs(std::atan2(point.y, point.x)) > 2.7) {
        continue;
      }
      ++returns;
      outside += beyond(boxes[point.object], point).maxCoeff() > 0.2;
      outside_at_rest += beyond(scene.objects[point.object].box, point).maxCoeff() > 0.2;
    }
  }
  EXPECT_GT(returns, 10000);
  EXPECT_LT(outside, returns / 100);
  EXPECT_GT(outside_at_rest, 10 * outside);
}

TEST(Labels, BoxesAreWhereTheScanShowsMovingObjectsFromAMovingVehicle) {
  expect_returns_in_scanned_boxes(false);
}

TEST(Labels, WithCompensationBoxesFollowTheObjectsOwnMovementAlone) {
  expect_returns_in_scanned_boxes(true);
}

TEST(Labels, WithNoiseNearlyAllReturnsLieInTheBox) {
  std::int64_t returns = 0, outside = 0;
  for (std::uint64_t index = 0; index < 3; ++index) {
    const Scene scene = resting_street(11, index);
    const LidarModel model = hdl64();
    for (const LidarReturn& point : scan(scene, RayTracer(scene, model.duration), model)) {
      if (point.object < 0) continue;
      ++returns;
      outside += beyond(scene.objects[point.object].box, point).maxCoeff() > 0.12;
    }
  }
  EXPECT_LT(static_cast<double>(outside), 0.01 * static_cast<double>(returns));
}

/// A vehicle straight ahead and a car farther on, which it hides when they stand in line.
Scene two_cars(double second_y, ModelKind first = ModelKind::kHatchback) {
  Scene scene;
  for (const Eigen::Vector3d& center :
       {Eigen::Vector3d(12, 0, -1), Eigen::Vector3d(25, second_y, -1)}) {
    place_car(scene, scene.objects.empty() ? first : ModelKind::kHatchback, center);
  }
  return scene;
}

SceneLabels labels_of(const Scene& scene, const CameraView& camera) {
  return make_labels(scene, scanned_boxes(scene, hdl64()), RayTracer(scene, 0.1), camera);
}

TEST(Labels, OcclusionFollowsWhatTheCameraSees) {
  const CameraView camera = kitti_camera(0);
  const Scene beside = two_cars(6.0);
  const SceneLabels free = labels_of(beside, camera);
  ASSERT_EQ(free.image.size(), 2u);
  EXPECT_EQ(free.image[0].occlusion, 0);
  EXPECT_EQ(free.image[1].occlusion, 0);
  const Scene half = two_cars(1.7);
  const SceneLabels partly = labels_of(half, camera);
  ASSERT_EQ(partly.image_objects.size(), 2u);
  EXPECT_EQ(partly.image[0].occlusion, 0);
  EXPECT_GE(partly.image[1].occlusion, 1);
  const Scene line = two_cars(0.0, ModelKind::kPanelVan);
  const SceneLabels hidden = labels_of(line, camera);
  EXPECT_EQ(hidden.image_objects, std::vector<std::size_t>{0});
  EXPECT_EQ(hidden.around_objects, std::vector<std::size_t>{1});
}

TEST(Labels, ObjectsOutsideOfTheViewGoAround) {
  Scene scene = two_cars(6.0);
  scene.objects[0].box.center.x() = -12.0;
  scene.instances[0].pose.translation().x() = -12.0;
  const SceneLabels labels = labels_of(scene, kitti_camera(1));
  EXPECT_EQ(labels.image_objects, std::vector<std::size_t>{1});
  ASSERT_EQ(labels.around_objects, std::vector<std::size_t>{0});
  EXPECT_EQ(labels.around[0].truncation, 1.0);
}

TEST(Labels, AsManyBoxesAsObjectsAreExpected) {
  const Scene scene = two_cars(6.0);
  EXPECT_THROW(make_labels(scene, {}, RayTracer(scene, 0.1), kitti_camera(0)), InvalidArgument);
}

TEST(Labels, TheBorderOfTheImageTruncates) {
  Scene scene = two_cars(6.0);
  const Eigen::Vector3d place(6.0, 4.6, -1.0);
  scene.objects[0].box.center = place;
  scene.instances[0].pose.translation() = place;
  const CameraView camera = kitti_camera(0);
  const SceneLabels labels = labels_of(scene, camera);
  ASSERT_FALSE(labels.image.empty());
  const io::KittiObject& cut = labels.image[0];
  EXPECT_GT(cut.truncation, 0.05);
  EXPECT_LT(cut.truncation, 0.95);
  EXPECT_EQ(cut.left, 0.0);
}

TEST(Labels, BoxesComeBackThroughTheCalibrationAndImageBoxesFitThem) {
  for (int day = 0; day < kKittiCameraCount; ++day) {
    StreetScanOptions options;
    options.camera = day;
    const StreetScan scan = street_scan(options, 5, static_cast<std::uint64_t>(day));
    EXPECT_EQ(io::known_image_size(scan.camera.calibration), scan.camera.image);
    const auto boxes = scan.boxes();
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const io::KittiObject& label = scan.labels.image[i];
      const geometry::Box back = io::to_box(label, scan.camera.calibration);
      EXPECT_LT((back.center - boxes[i].center).norm(), 1e-6);
      EXPECT_LT((back.size - boxes[i].size).norm(), 1e-9);
      const auto whole = io::projected_box(label, scan.camera.calibration);
      ASSERT_TRUE(whole);
      if (label.z < 4.0) continue;
      EXPECT_GT(label.left, whole->left - 25.0);
      EXPECT_LT(label.right, whole->right + 25.0);
      EXPECT_GT(label.top, whole->top - 12.0);
      EXPECT_LT(label.bottom, whole->bottom + 12.0);
    }
  }
}

TEST(Labels, TheGroundPlaneLiesUnderTheVehicle) {
  const Scene scene = street_scene({}, 2, 0);
  const CameraView camera = kitti_camera(0);
  const io::KittiPlane plane = io::plane_in_lidar(ground_plane(scene, camera), camera.calibration);
  EXPECT_NEAR(plane.offset, scene.ground_offset, 1e-6);
  EXPECT_LT((plane.normal - scene.ground_normal).norm(), 1e-6);
}

TEST(Labels, DaysThatAreNotThereAreRefused) {
  EXPECT_THROW(kitti_camera(4), InvalidArgument);
  EXPECT_THROW(kitti_camera(-1), InvalidArgument);
}

}  // namespace
}  // namespace arbox::simulation
