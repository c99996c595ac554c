#include "arbox/detectors/cluster_fit/internal/l_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/geometry/box.h"

namespace arbox::detectors::internal {
namespace {

/// Points on the sides of a box that face the origin.
std::vector<Eigen::Vector2d> visible_sides(const geometry::Box& box, double noise) {
  const RandomStream draw(5, 0, 0);
  std::vector<Eigen::Vector2d> points;
  const Eigen::Vector3d sensor = box.rotation.conjugate() * (-box.center);
  std::uint32_t next = 0;
  for (int axis : {0, 1}) {
    const double half = 0.5 * box.size[axis];
    if (std::abs(sensor[axis]) <= half) continue;
    const double along = 0.5 * box.size[1 - axis];
    for (double step = -1.0; step <= 1.0; step += 0.02) {
      Eigen::Vector3d local = Eigen::Vector3d::Zero();
      local[axis] = std::copysign(half, sensor[axis]) + noise * draw.normal(next++);
      local[1 - axis] = step * along;
      points.push_back((box.center + box.rotation * local).head<2>());
    }
  }
  return points;
}

double quarter_difference(double one, double other) {
  return std::abs(std::remainder(one - other, 0.5 * std::numbers::pi));
}

class LShape : public testing::TestWithParam<double> {};

TEST_P(LShape, IsExactWithoutNoise) {
  for (double yaw = -3.14; yaw < 3.14; yaw += 0.083) {
    const double bearing = GetParam();
    const geometry::Box box = geometry::make_yaw_box(
        {14 * std::cos(bearing), 14 * std::sin(bearing), 0}, {4.1, 1.7, 1.5}, yaw);
    const auto points = visible_sides(box, 0.0);
    const Rectangle found = fit_l_shape(points);
    ASSERT_LT(quarter_difference(found.yaw, yaw), 1e-3) << "yaw " << yaw;
    // Both sides are seen unless the box shows one face only.
    if (points.size() < 150) continue;
    const bool axis0_is_length = std::abs(std::remainder(found.yaw - yaw, std::numbers::pi)) < 0.1;
    const Eigen::Vector2d extent = found.high - found.low;
    // One point of a hundred may lie outside of each side: steps of a hundredth of the size.
    ASSERT_NEAR(extent[axis0_is_length ? 0 : 1], 4.1, 0.031 * 4.1) << "yaw " << yaw;
    ASSERT_NEAR(extent[axis0_is_length ? 1 : 0], 1.7, 0.031 * 1.7) << "yaw " << yaw;
  }
}

TEST_P(LShape, StaysWithinADegreeUnderScannerNoise) {
  for (double yaw = -3.14; yaw < 3.14; yaw += 0.083) {
    const double bearing = GetParam();
    const geometry::Box box = geometry::make_yaw_box(
        {14 * std::cos(bearing), 14 * std::sin(bearing), 0}, {4.1, 1.7, 1.5}, yaw);
    const auto points = visible_sides(box, 0.02);
    if (points.size() < 150) continue;
    ASSERT_LT(quarter_difference(fit_l_shape(points).yaw, yaw), 0.02) << "yaw " << yaw;
  }
}

INSTANTIATE_TEST_SUITE_P(Bearings, LShape, testing::Values(0.0, 0.7, 1.6, 2.9, -0.4, -2.1));

TEST(LShapeSearch, StaysNearTheHeadingItIsGiven) {
  const geometry::Box box = geometry::make_yaw_box({12, 3, 0}, {4, 1.7, 1.5}, 0.02);
  const Rectangle found = fit_l_shape(visible_sides(box, 0.0), {.around = -0.03, .window = 0.1});
  EXPECT_NEAR(found.yaw, 0.02, 1e-3);
}

TEST(LShapeSearch, GivesTheHeadingsWithTheMostSupportBestFirst) {
  // Two walls that meet at 45 degrees: each is a side of a rectangle of its own.
  std::vector<Eigen::Vector2d> points;
  for (double step = 0.0; step < 1.0; step += 0.02) {
    points.emplace_back(10.0, 2.0 * step);
    points.emplace_back(10.0 + step, -step);
  }
  const auto found = l_shapes(points, 0.035, 3);
  ASSERT_GE(found.size(), 2u);
  EXPECT_LE(found.size(), 3u);
  EXPECT_GE(found[0].support, fit_l_shape(points).support);
  std::vector<double> misses;
  for (const double heading : {0.0, 0.25 * std::numbers::pi}) {
    misses.push_back(std::min(quarter_difference(found[0].yaw, heading),
                              quarter_difference(found[1].yaw, heading)));
  }
  EXPECT_LT(misses[0], 0.02);
  EXPECT_LT(misses[1], 0.02);
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_LE(found[i].support, found[i - 1].support);
  }
}

TEST(LShapeSearch, TellsWhereThePointsLieBehindTheSides) {
  std::vector<Eigen::Vector2d> points;
  for (double step = 0.0; step < 1.0; step += 0.01) points.emplace_back(10.0, 4.0 * step);
  for (int i = 0; i < 50; ++i) points.emplace_back(10.4, 2.0);
  const Rectangle found = l_shapes(points, 0.035, 1)[0];
  const int axis = quarter_difference(found.yaw, 0.0) < 0.01 && found.yaw < 0.5 ? 0 : 1;
  EXPECT_NEAR(found.share[axis] + found.share[1 - axis], 1.0, 0.02);
  EXPECT_GT(found.share[axis], 0.9);
  EXPECT_NEAR(found.depth[axis], 0.4 / 3.0, 0.02);
}

TEST(Rectangle, KnowsTheSideOfTheSensor) {
  const Rectangle rectangle{.yaw = 0.0, .low = {2, -1}, .high = {6, 1}};
  EXPECT_EQ(rectangle.sensor_side(0), -1);
  EXPECT_EQ(rectangle.sensor_side(1), 0);
  EXPECT_EQ(rectangle.corner(1, 0), Eigen::Vector2d(6, -1));
}

TEST(LShapeSearch, OfOnePointIsThePoint) {
  const std::vector<Eigen::Vector2d> points = {{3, 4}};
  const Rectangle found = fit_l_shape(points);
  EXPECT_NEAR((found.corner(0, 0) - points[0]).norm(), 0.0, 1e-9);
  EXPECT_NEAR((found.high - found.low).norm(), 0.0, 1e-9);
}

}  // namespace
}  // namespace arbox::detectors::internal
