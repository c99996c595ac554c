#include "arbox/geometry/enclosing_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/geometry/internal/rectangle.h"
#include "support/box_samples.h"

namespace {

using namespace arbox::geometry;
using namespace arbox::testing;
using Eigen::Vector2d;
using Eigen::Vector3d;

using Points = std::vector<Vector3d>;

void expect_holds(const Box& box, const Points& points) {
  ASSERT_NO_THROW(require_valid(box, "test"));
  for (const Vector3d& point : points) ASSERT_TRUE(contains(box, point, 1e-9)) << point.transpose();
}

Points points_in(std::mt19937_64& random, const Box& box, int count) {
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  Points points;
  for (int i = 0; i < count; ++i) {
    const Vector3d local(unit(random), unit(random), unit(random));
    points.push_back(box.center + box.rotation * local.cwiseProduct(box.size));
  }
  return points;
}

Points ball(std::mt19937_64& random, int count) {
  std::normal_distribution<double> normal;
  Points points;
  for (int i = 0; i < count; ++i) {
    points.push_back(Vector3d(normal(random), normal(random), normal(random)));
  }
  return points;
}

TEST(Rectangle, TheHullHoldsAllPointsAndTurnsLeft) {
  std::mt19937_64 random(2);
  std::uniform_int_distribution<int> whole(-6, 6);
  for (const int count : {1, 2, 3, 5, 20, 200, 1000}) {
    std::vector<Vector2d> points;
    for (int i = 0; i < count; ++i) points.emplace_back(whole(random), whole(random));
    const auto all = points;
    const auto hull = internal::convex_hull(points);
    if (hull.size() < 3) continue;
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Vector2d a = hull[i];
      const Vector2d edge = hull[(i + 1) % hull.size()] - a;
      for (const Vector2d& p : all) {
        EXPECT_GE(edge.x() * (p - a).y() - edge.y() * (p - a).x(), 0.0);
      }
    }
  }
}

TEST(Rectangle, IsNotBeatenByAnyOfManyAngles) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Vector2d> points;
    for (int i = 0; i < 3 + trial; ++i) points.emplace_back(3 * normal(random), normal(random));
    auto copy = points;
    const auto least = internal::least_rectangle(copy, 0.0);
    const auto area_at = [&](double angle) {
      const Vector2d u(std::cos(angle), std::sin(angle));
      const Vector2d v(-u.y(), u.x());
      Eigen::AlignedBox2d extents;
      for (const Vector2d& p : points) extents.extend(Vector2d(u.dot(p), v.dot(p)));
      return extents.volume();
    };
    EXPECT_NEAR(area_at(least.angle), least.area, 1e-9 * least.area);
    for (int i = 0; i < 400; ++i) {
      EXPECT_LE(least.area, area_at(i * std::numbers::pi / 800) * (1 + 1e-12));
    }
  }
}

TEST(EnclosingBox, TakesTheBestOfTheGivenRotations) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Box box = scattered_samples(random, 1, 0.5, false).front();
    Points points;
    for (const Vector3d& corner : corners(box)) points.push_back(corner);
    const std::vector<Quaternion> rotations = {Quaternion::Identity(), box.rotation,
                                               random_rotation(random, false)};
    const Box result = *enclosing_box(points, rotations);
    expect_holds(result, points);
    EXPECT_NEAR(volume(result), volume(box), 1e-9 * volume(box));
    EXPECT_EQ(result.rotation.coeffs(), box.rotation.normalized().coeffs());
  }
}

TEST(EnclosingBox, YawBoxesAreExact) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 100; ++trial) {
    const Box box = scattered_samples(random, 1, 0.5, true).front();
    Points points = points_in(random, box, 30);
    for (const Vector3d& corner : corners(box)) points.push_back(corner);
    const Box result = *minimum_volume_yaw_box(points);
    expect_holds(result, points);
    EXPECT_TRUE(is_yaw_only(result));
    EXPECT_NEAR(volume(result), volume(box), 1e-9 * volume(box));
    EXPECT_GE(result.size.x(), result.size.y());
    EXPECT_GT(yaw(result), -std::numbers::pi / 2 - 1e-12);
    EXPECT_LE(yaw(result), std::numbers::pi / 2 + 1e-12);
  }
}

TEST(MinimumVolumeBox, FindsTurnedBoxesFromTheirCornersOrManyPoints) {
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 60; ++trial) {
    Box box = scattered_samples(random, 1, 1.0, false).front();
    Points points;
    for (const Vector3d& corner : corners(box)) points.push_back(corner);
    if (trial % 2 == 0) {
      const Points inner = points_in(random, box, 200);
      points.insert(points.end(), inner.begin(), inner.end());
    }
    const Box result = *minimum_volume_box(points);
    expect_holds(result, points);
    EXPECT_NEAR(volume(result) / volume(box), 1.0, 1e-6) << trial;
    EXPECT_GE(result.size.x(), result.size.y());
    EXPECT_GE(result.size.y(), result.size.z());
  }
}

TEST(MinimumVolumeBox, KnownSolids) {
  // A regular tetrahedron in every second corner of a cube: the cube is its smallest box.
  const Points tetrahedron = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  std::mt19937_64 random(13);
  Points points;
  const Quaternion turn = random_rotation(random, false);
  for (const Vector3d& p : tetrahedron) points.push_back(turn * p);
  EXPECT_NEAR(volume(*minimum_volume_box(points)), 8.0, 1e-6);
  // A cylinder of many sides and height 3 along a tilted axis: the square around the disc.
  points.clear();
  for (int i = 0; i < 360; ++i) {
    const double angle = i * std::numbers::pi / 180;
    for (const double z : {0.0, 3.0}) {
      points.push_back(turn * Vector3d(2 * std::cos(angle), 2 * std::sin(angle), z));
    }
  }
  EXPECT_NEAR(volume(*minimum_volume_box(points)), 48.0, 48.0 * 1e-3);
}

TEST(MinimumVolumeBox, IsNeverLargerThanTheSimpleBoxesAndIsALocalMinimum) {
  std::mt19937_64 random(17);
  for (int trial = 0; trial < 12; ++trial) {
    const Points points = ball(random, 4 + 10 * trial);
    const Box result = *minimum_volume_box(points);
    expect_holds(result, points);
    const double least = volume(result);
    const std::vector<Quaternion> frame = {Quaternion::Identity()};
    EXPECT_LE(least, volume(*enclosing_box(points, frame)));
    EXPECT_LE(least, volume(*minimum_volume_yaw_box(points)) * (1 + 1e-12));
    for (int a = 0; a < 3; ++a) {
      for (int i = 1; i < 180; ++i) {
        const Quaternion turned(Eigen::Quaterniond(result.rotation) *
                                Eigen::AngleAxisd(i * std::numbers::pi / 180, Vector3d::Unit(a)));
        const std::vector<Quaternion> one = {turned.normalized()};
        EXPECT_LE(least, volume(*enclosing_box(points, one)) * (1 + 1e-9));
      }
    }
  }
}

TEST(EnclosingBox, DegenerateSetsHaveValidBoxes) {
  const std::vector<Quaternion> frame = {Quaternion::Identity()};
  const Vector3d direction = Vector3d(1, 2, 3).normalized();
  const std::vector<Points> sets = {
      {{1e6, 2, 3}},
      {{1, 2, 3}, {1, 2, 3}},
      {Vector3d::Zero(), 2 * direction, direction},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
      {{0, 0, 0}, {1, 1, 1}, {2, 1, 0}},
  };
  for (const Points& points : sets) {
    expect_holds(*enclosing_box(points, frame), points);
    expect_holds(*minimum_volume_yaw_box(points), points);
    expect_holds(*minimum_volume_box(points), points);
  }
  EXPECT_NEAR(minimum_volume_box(sets[2])->size.x(), 2.0, 1e-9);
  EXPECT_EQ(minimum_volume_box(sets[2])->size.y(), kMinimumBoxSize);
  EXPECT_EQ(minimum_volume_box(sets[3])->size.z(), kMinimumBoxSize);
  EXPECT_NEAR(volume(*minimum_volume_box(sets[3])), kMinimumBoxSize, 1e-12);
}

TEST(EnclosingBox, EmptyAndBadInput) {
  const std::vector<Quaternion> frame = {Quaternion::Identity()};
  EXPECT_FALSE(enclosing_box({}, frame));
  EXPECT_FALSE(minimum_volume_yaw_box({}));
  EXPECT_FALSE(minimum_volume_box({}));
  Points points = {{0, 0, 0}, {1, 1, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_THROW(minimum_volume_box(points), arbox::InvalidArgument);
  EXPECT_THROW(minimum_volume_yaw_box(points), arbox::InvalidArgument);
  EXPECT_THROW(enclosing_box(points, frame), arbox::InvalidArgument);
  points.pop_back();
  EXPECT_THROW(enclosing_box(points, {}), arbox::InvalidArgument);
  EXPECT_THROW(enclosing_box(points, std::vector<Quaternion>{{2, 0, 0, 0}}),
               arbox::InvalidArgument);
  EXPECT_THROW(minimum_volume_box(points, 0.0), arbox::InvalidArgument);
}

TEST(BoxBetween, GoesFromTheBoxAroundTheInnerOneToTheOuterOne) {
  const Box inner = make_yaw_box({101, 0, 0}, {2, 2, 2}, 0);
  const Box outer = make_yaw_box({100, 0, 0}, {8, 4, 2}, 0);
  const Box half = box_between(inner, outer, 0.5);
  EXPECT_NEAR((half.center - Eigen::Vector3d(100.5, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((half.size - Eigen::Vector3d(5, 3, 2)).norm(), 0, 1e-12);
  const Box turned = make_yaw_box({100, 0, 0}, {2, 2, 2}, std::numbers::pi / 4);
  EXPECT_NEAR(box_between(turned, outer, 0).size.x(), std::sqrt(8), 1e-12);
  EXPECT_NEAR(box_between(make_yaw_box({104, 0, 0}, {2, 2, 2}, 0), outer, 0).size.x(), 1, 1e-12)
      << "what lies outside is cut off";
}

TEST(BoxBetween, LargerSharesContainSmallerOnesAndWhatBothContain) {
  std::mt19937_64 random(71);
  for (int trial = 0; trial < 200; ++trial) {
    const auto boxes = arbox::testing::scattered_samples(random, 2, 0.5, trial % 2 == 0);
    Box before = box_between(boxes[0], boxes[1], 0);
    for (const Eigen::Vector3d& corner : corners(boxes[0])) {
      EXPECT_TRUE(!contains(boxes[1], corner, 0) || contains(before, corner, 1e-9));
    }
    for (const double share : {0.1, 0.35, 0.8, 1.0}) {
      const Box box = box_between(boxes[0], boxes[1], share);
      for (const Eigen::Vector3d& corner : corners(before)) {
        EXPECT_TRUE(contains(box, corner, 1e-6)) << trial << " " << share;
      }
      before = box;
    }
    EXPECT_EQ(before.size, boxes[1].size);
  }
}

TEST(BoxBetween, RefusesBadInput) {
  const Box box = make_yaw_box({0, 0, 0}, {1, 1, 1}, 0);
  for (const double share : {-0.1, 1.1, std::nan("")}) {
    EXPECT_THROW(box_between(box, box, share), arbox::InvalidArgument);
  }
  EXPECT_THROW(box_between(box, {.size = {0, 1, 1}}, 0.5), arbox::InvalidArgument);
  EXPECT_THROW(box_between({.size = {1, std::nan(""), 1}}, box, 0.5), arbox::InvalidArgument);
  EXPECT_GT(box_between(make_yaw_box({50, 0, 0}, {1, 1, 1}, 0), box, 0).size.minCoeff(), 0)
      << "boxes that do not meet still give a box";
}

}  // namespace
