#include "arbox/training/points_in_boxes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace arbox::training {
namespace {

using geometry::Box;
using geometry::PointCloud;
using ::testing::IsEmpty;

/// Boxes that overlap, lie far out, are thin, and one turned out of the level.
std::vector<Box> made_boxes(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-30, 30), size(0.2, 6), turn(-3, 3);
  std::vector<Box> boxes;
  for (int i = 0; i < 40; ++i) {
    boxes.push_back(geometry::make_yaw_box({place(random), place(random), 0},
                                           {size(random), size(random), 2}, turn(random)));
  }
  boxes.push_back(geometry::make_yaw_box({1e5, -2e5, 0}, {4, 2, 2}, 0.3));
  boxes.push_back(geometry::make_yaw_box({0, 0, 0}, {50, 0.01, 2}, 0.7));
  Box tilted = geometry::make_yaw_box({5, 5, 0}, {6, 2, 4}, 1.0);
  tilted.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX())) * tilted.rotation;
  boxes.push_back(tilted);
  return boxes;
}

PointCloud made_cloud(std::mt19937& random, const std::vector<Box>& boxes) {
  std::uniform_real_distribution<float> place(-35, 35), height(-2, 2);
  PointCloud cloud{.channels = {"intensity"}, .values = {}};
  const auto add = [&](float x, float y, float z) {
    cloud.values.insert(cloud.values.end(), {x, y, z, 0.5f});
  };
  for (int i = 0; i < 20000; ++i) add(place(random), place(random), height(random));
  for (const Box& box : boxes) {
    for (const auto& corner : geometry::corners(box)) {
      add(static_cast<float>(corner.x()), static_cast<float>(corner.y()),
          static_cast<float>(corner.z()));
    }
    const Eigen::Vector3f center = box.center.cast<float>();
    add(center.x(), center.y(), center.z());
  }
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  add(kNan, 0, 0);
  add(0, 0, std::numeric_limits<float>::infinity());
  return cloud;
}

bool holds(const Box& box, const PointCloud& cloud, std::size_t i) {
  const float* row = &cloud.values[4 * i];
  const Eigen::Vector3d point(row[0], row[1], row[2]);
  return point.allFinite() && geometry::contains(box, point);
}

TEST(PointsInBoxes, AgreesWithAskingEveryBoxAboutEveryPoint) {
  std::mt19937 random(1);
  const std::vector<Box> boxes = made_boxes(random);
  const PointCloud cloud = made_cloud(random, boxes);
  const auto found = points_inside(cloud, boxes);
  ASSERT_EQ(found.size(), boxes.size());
  std::vector<SceneObject> objects;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (holds(boxes[b], cloud, i)) expected.push_back(i);
    }
    EXPECT_EQ(found[b], expected) << b;
    objects.push_back({.box = boxes[b]});
  }
  const auto counts = count_points(cloud, objects);
  for (std::size_t b = 0; b < boxes.size(); ++b) EXPECT_EQ(counts[b], std::ssize(found[b]));
}

TEST(PointsInBoxes, RemovesExactlyThePointsInside) {
  std::mt19937 random(2);
  const std::vector<Box> boxes = made_boxes(random);
  const PointCloud cloud = made_cloud(random, boxes);
  PointCloud expected{.channels = cloud.channels, .values = {}};
  for (std::size_t i = 0; i + 2 < cloud.size(); ++i) {
    bool inside = false;
    for (const Box& box : boxes) inside = inside || holds(box, cloud, i);
    const auto row = cloud.values.begin() + static_cast<std::ptrdiff_t>(4 * i);
    if (!inside) expected.values.insert(expected.values.end(), row, row + 4);
  }
  PointCloud changed = cloud;
  changed.values.resize(changed.values.size() - 8);
  remove_points_inside(changed, boxes);
  EXPECT_LT(changed.size(), cloud.size() - 2);
  EXPECT_EQ(changed.values, expected.values);
}

TEST(PointsInBoxes, NoPointsAndNoBoxesAreFine) {
  std::mt19937 random(3);
  const std::vector<Box> boxes = made_boxes(random);
  PointCloud empty{.channels = {"intensity"}, .values = {}};
  EXPECT_EQ(points_inside(empty, boxes).size(), boxes.size());
  remove_points_inside(empty, boxes);
  EXPECT_THAT(empty.values, IsEmpty());
  PointCloud cloud = made_cloud(random, boxes);
  const std::size_t before = cloud.size();
  EXPECT_THAT(points_inside(cloud, {}), IsEmpty());
  remove_points_inside(cloud, {});
  EXPECT_EQ(cloud.size(), before);
}

}  // namespace
}  // namespace arbox::training
