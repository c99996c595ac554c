#include "arbox/geometry/overlap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/geometry/internal/overlap_engine.h"
#include "arbox/geometry/rotation.h"
#include "geometry/overlap_pairs.h"
#include "support/refusal.h"

namespace {

using ::arbox::testing::refusal;
using namespace arbox;
using namespace arbox::geometry;
using arbox::testing::random_box;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr OverlapOptions kVolume{.measure = Overlap::kIntersection};
constexpr OverlapOptions kIog{.measure = Overlap::kIog};
constexpr OverlapOptions kBirdsEye{.space = OverlapSpace::kBirdsEye};

std::vector<Box> random_boxes(int count, std::uint64_t seed) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    boxes.push_back(random_box(RandomStream(seed, i, 0), i % 3 == 0, 3.0));
  }
  return boxes;
}

Box cube(double x, double y, double z, double side = 1.0) {
  return {.center = {x, y, z}, .size = Vector3d::Constant(side)};
}

TEST(Overlap, OfKnownPairsIsWhatGeometrySays) {
  EXPECT_DOUBLE_EQ(overlap(cube(0, 0, 0), cube(0.5, 0, 0), kVolume), 0.5);
  EXPECT_DOUBLE_EQ(overlap(cube(0, 0, 0), cube(0.5, 0, 0)), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(overlap(cube(0, 0, 0), cube(0.25, 0.5, 0.75), kVolume), 0.75 * 0.5 * 0.25);
  const Box turned = make_yaw_box({0, 0, 0}, {1, 1, 1}, std::numbers::pi / 4);
  EXPECT_NEAR(overlap(cube(0, 0, 0), turned, kVolume), 2 * (std::numbers::sqrt2 - 1), 1e-15);
  // A cube that stands on its corner, cut by slabs at a third of its diagonal, leaves a half.
  const Quaternion on_corner(
      Eigen::Quaterniond::FromTwoVectors(Vector3d::Ones(), Vector3d::UnitZ()));
  const Box standing{.size = Vector3d::Ones(), .rotation = on_corner};
  const Box lower_half{.center = {0, 0, -5}, .size = {10, 10, 10}};
  EXPECT_NEAR(overlap(standing, lower_half, kVolume), 0.5, 1e-15);
  const Box middle{.size = {10, 10, std::sqrt(3.0) / 3}};
  EXPECT_NEAR(overlap(standing, middle, kVolume), 2.0 / 3.0, 1e-15);
}

TEST(Overlap, IogDividesByTheSecondBox) {
  EXPECT_DOUBLE_EQ(overlap(cube(0, 0, 0, 2), cube(0, 0, 0, 1), kIog), 1.0);
  EXPECT_DOUBLE_EQ(overlap(cube(0, 0, 0, 1), cube(0, 0, 0, 2), kIog), 0.125);
}

TEST(Overlap, OfSeparateAndTouchingBoxesIsZero) {
  EXPECT_EQ(overlap(cube(0, 0, 0), cube(3, 0, 0)), 0.0);
  EXPECT_EQ(overlap(cube(0, 0, 0), cube(1, 0, 0)), 0.0);
  EXPECT_EQ(overlap(cube(0, 0, 0), cube(0, 1, 0)), 0.0);
  EXPECT_EQ(overlap(cube(0, 0, 0), cube(0, 0, 1)), 0.0);
  EXPECT_EQ(overlap(cube(0, 0, 0), cube(1, 1, 1)), 0.0);
  EXPECT_EQ(overlap(make_yaw_box({0, 0, 0}, {4, 2, 1}, 0.3),
                    make_yaw_box({-0.7, 2.3, 0}, {4, 2, 1}, 0.3)),
            0.0);
  const Quaternion tilt(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())));
  EXPECT_EQ(overlap({.rotation = tilt}, {.center = {1.9, 0, 0}}), 0.0);
  EXPECT_EQ(overlap(cube(-1e308, 0, 0), cube(1e308, 0, 0)), 0.0);
}

TEST(Overlap, OfABoxWithItsEquivalentsIsOneAtEveryLevelPlaceAndSize) {
  for (const SimdLevel level : {SimdLevel::kScalar, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (level > simd_level()) continue;
    for (int i = 0; i < 200; ++i) {
      const RandomStream stream(3, i, 0);
      Box box = random_box(stream, i % 2 == 1);
      if (i % 5 == 1) box.center += Vector3d(1e6, -1e6, 1e6);
      if (i % 5 == 2) box.size *= 1e6;
      if (i % 5 == 3) box.size.z() = 1e-4;
      if (i % 5 == 4) box.size *= 1e-30;
      for (const Box& equivalent : equivalent_boxes(box)) {
        const double iou = internal::overlap_at(level, box, equivalent, {});
        ASSERT_NEAR(iou, 1.0, 1e-9) << "box " << i << " at " << to_string(level);
        ASSERT_LE(iou, 1.0);
        ASSERT_LE(internal::overlap_at(level, box, equivalent, kIog), 1.0);
      }
    }
  }
}

TEST(Overlap, MatrixPairsAndSingleCallsGiveTheSameBytesAtAnyThreadCount) {
  const std::vector<Box> first = random_boxes(70, 1), second = random_boxes(131, 2);
  for (const Overlap measure : {Overlap::kIntersection, Overlap::kIou, Overlap::kIog}) {
    const auto one = overlap_matrix(first, second, {.measure = measure, .threads = 1});
    const auto many = overlap_matrix(first, second, {.measure = measure, .threads = 4});
    EXPECT_TRUE((one.array() == many.array()).all());
    EXPECT_GT((one.array() > 0.0).count(), 500);
    for (int row = 0; row < one.rows(); ++row) {
      const std::vector<Box> repeated(second.size(), first[row]);
      const Eigen::VectorXd pairs = overlap_pairs(repeated, second, {.measure = measure});
      for (int column = 0; column < one.cols(); ++column) {
        ASSERT_EQ(one(row, column), overlap(first[row], second[column], {.measure = measure}));
        ASSERT_EQ(one(row, column), pairs[column]);
      }
    }
  }
}

TEST(Overlap, OfNoBoxesIsEmpty) {
  const std::vector<Box> none, two(2);
  EXPECT_EQ(overlap_matrix(none, two).rows(), 0);
  EXPECT_EQ(overlap_matrix(two, none).rows(), 2);
  EXPECT_EQ(overlap_matrix(two, none).cols(), 0);
  EXPECT_EQ(overlap_pairs(none, none).size(), 0);
}

TEST(BirdsEyeOverlap, IsTheAreaOfTheBases) {
  const Box low = make_yaw_box({1, 2, -50}, {4, 2, 1}, 0.4);
  const Box high = make_yaw_box({1.3, 1.8, 70}, {3, 1, 8}, -0.9);
  const Box low_at_zero = make_yaw_box({1, 2, 0}, {4, 2, 1}, 0.4);
  const Box high_at_zero = make_yaw_box({1.3, 1.8, 0}, {3, 1, 1}, -0.9);
  for (const Overlap measure : {Overlap::kIntersection, Overlap::kIou, Overlap::kIog}) {
    EXPECT_NEAR(overlap(low, high, {.measure = measure, .space = OverlapSpace::kBirdsEye}),
                overlap(low_at_zero, high_at_zero, {.measure = measure}), 1e-15);
  }
}

TEST(BirdsEyeOverlap, RefusesTiltedBoxesAndForgivesFloatRounding) {
  const auto tilted = [](double angle) {
    Box box;
    box.rotation = Quaternion(Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) *
                                                 Eigen::AngleAxisd(angle, Vector3d::UnitX())));
    return box;
  };
  EXPECT_NEAR(overlap(tilted(1e-7), make_yaw_box({0, 0, 0}, {1, 1, 1}, 0.3), kBirdsEye), 1.0,
              1e-12);
  const std::vector<Box> boxes = {tilted(0), tilted(1e-3)};
  const std::string message = refusal([&] { overlap_matrix(boxes, boxes, kBirdsEye); });
  EXPECT_THAT(message, HasSubstr("row 1"));
  EXPECT_THAT(message, HasSubstr("+z"));
  EXPECT_THAT(refusal([&] { overlap(tilted(std::numbers::pi), boxes[0], kBirdsEye); }),
              HasSubstr("+z"));
}

TEST(AxisAlignedOverlap, IgnoresRotations) {
  const std::vector<Box> boxes = random_boxes(60, 5);
  const auto got = overlap_matrix(
      boxes, boxes, {.measure = Overlap::kIntersection, .space = OverlapSpace::kAxisAligned});
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      const Vector3d low =
          (boxes[i].center - boxes[i].size / 2).cwiseMax(boxes[j].center - boxes[j].size / 2);
      const Vector3d high =
          (boxes[i].center + boxes[i].size / 2).cwiseMin(boxes[j].center + boxes[j].size / 2);
      ASSERT_NEAR(got(i, j), (high - low).cwiseMax(0.0).prod(), 1e-12);
    }
  }
}

TEST(Overlap, RefusesInvalidBoxesAndNamesTheRow) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Box> good(4);
  for (const double size : {0.0, -1.0, infinity, nan, 1e-60, 1e60, 5e-324}) {
    std::vector<Box> bad = good;
    bad[2].size.y() = size;
    for (const OverlapSpace space :
         {OverlapSpace::k3d, OverlapSpace::kBirdsEye, OverlapSpace::kAxisAligned}) {
      EXPECT_THAT(refusal([&] { overlap_matrix(good, bad, {.space = space}); }), HasSubstr("row 2"))
          << size;
      EXPECT_THAT(refusal([&] { overlap_pairs(bad, good, {.space = space}); }), HasSubstr("row 2"))
          << size;
      EXPECT_THAT(refusal([&] { overlap(good[0], bad[2], {.space = space}); }), HasSubstr("second"))
          << size;
    }
  }
  std::vector<Box> bad = good;
  bad[3].rotation = Quaternion(0.9, 0, 0, 0);
  EXPECT_THAT(refusal([&] { overlap_matrix(bad, good); }), HasSubstr("row 3"));
  bad[3].rotation = Quaternion(nan, 0, 0, 0);
  EXPECT_THAT(refusal([&] { overlap_matrix(bad, good); }), HasSubstr("row 3"));
  bad = good;
  bad[1].center.x() = infinity;
  EXPECT_THAT(refusal([&] { overlap_pairs(good, bad); }), HasSubstr("row 1"));
  EXPECT_THAT(refusal([&] { overlap_pairs(good, std::vector<Box>(3)); }),
              HasSubstr("4 first and 3 second"));
}

}  // namespace
