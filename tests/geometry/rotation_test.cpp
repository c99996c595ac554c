#include "arbox/geometry/rotation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numbers>

#include "support/random_boxes.h"

namespace {

using namespace arbox::geometry;
using namespace arbox::testing;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

Matrix3d matrix(double angle, const Vector3d& axis) {
  return AngleAxisd(angle, axis).toRotationMatrix();
}

Matrix3d matrix(const ZyzAngles& a) {
  return matrix(a.alpha, Vector3d::UnitZ()) * matrix(a.beta, Vector3d::UnitY()) *
         matrix(a.gamma, Vector3d::UnitZ());
}

Matrix3d matrix(const RollPitchYaw& a) {
  return matrix(a.yaw, Vector3d::UnitZ()) * matrix(a.pitch, Vector3d::UnitY()) *
         matrix(a.roll, Vector3d::UnitX());
}

double error(const Matrix3d& a, const Quaternion& b) {
  return (a - b.toRotationMatrix()).cwiseAbs().maxCoeff();
}

bool in_zyz_range(const ZyzAngles& a) {
  return a.alpha >= 0 && a.alpha < 2 * kPi && a.beta >= 0 && a.beta <= kPi && a.gamma >= 0 &&
         a.gamma < 2 * kPi;
}

bool in_rpy_range(const RollPitchYaw& a) {
  return a.roll > -kPi && a.roll <= kPi && std::abs(a.pitch) <= kPi / 2 && a.yaw > -kPi &&
         a.yaw <= kPi;
}

/// True if the two boxes have the same eight corners, in any order.
bool same_space(const Box& a, const Box& b, double tolerance) {
  for (const Vector3d& corner : corners(a)) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector3d& other : corners(b)) nearest = std::min(nearest, (corner - other).norm());
    if (nearest > tolerance) return false;
  }
  return true;
}

RC_GTEST_PROP(Rotation, EulerAnglesRoundTrip, ()) {
  const Quaternion q = *any_rotation();
  const ZyzAngles zyz = zyz_angles(q);
  RC_ASSERT(in_zyz_range(zyz));
  RC_ASSERT(error(matrix(zyz), q) < 1e-12);
  RC_ASSERT(error(matrix(zyz), to_quaternion(zyz)) < 1e-12);
  const RollPitchYaw rpy = roll_pitch_yaw(q);
  RC_ASSERT(in_rpy_range(rpy));
  RC_ASSERT(error(matrix(rpy), q) < 1e-12);
  RC_ASSERT(error(matrix(rpy), to_quaternion(rpy)) < 1e-12);
}

TEST(Rotation, ZyzAtAndNearTheGimbal) {
  for (const double beta : {0.0, 1e-15, 1e-11, 1e-9, 1e-6, kPi - 1e-6, kPi - 1e-11, kPi}) {
    for (const double alpha : {0.0, 0.3, 3.0, 6.2}) {
      for (const double gamma : {0.0, 0.7, 5.0}) {
        const Quaternion q = to_quaternion(ZyzAngles{alpha, beta, gamma});
        const ZyzAngles back = zyz_angles(q);
        EXPECT_TRUE(in_zyz_range(back));
        EXPECT_LT(error(matrix(back), q), 1e-11) << beta << ' ' << alpha << ' ' << gamma;
      }
    }
  }
  const ZyzAngles flat = zyz_angles(to_quaternion(ZyzAngles{0.4, 0.0, 0.5}));
  EXPECT_NEAR(flat.alpha, 0.9, 1e-12);
  EXPECT_EQ(flat.gamma, 0.0);
  const ZyzAngles flipped = zyz_angles(Quaternion(0, 1, 0, 0));
  EXPECT_EQ(flipped.beta, kPi);
  EXPECT_EQ(flipped.gamma, 0.0);
  const ZyzAngles identity = zyz_angles(Quaternion::Identity());
  EXPECT_EQ(identity.alpha, 0.0);
  EXPECT_EQ(identity.beta, 0.0);
}

TEST(Rotation, RollPitchYawAtAndNearTheGimbal) {
  for (const double sign : {-1.0, 1.0}) {
    for (const double off : {0.0, 1e-15, 1e-11, 1e-9, 1e-6}) {
      for (const double roll : {0.0, 0.7, -2.0}) {
        for (const double yaw_angle : {0.0, 0.3, 3.0, -3.0}) {
          const RollPitchYaw angles{roll, sign * (kPi / 2 - off), yaw_angle};
          const Quaternion q = to_quaternion(angles);
          const RollPitchYaw back = roll_pitch_yaw(q);
          EXPECT_TRUE(in_rpy_range(back));
          EXPECT_LT(error(matrix(back), q), 1e-11) << sign << ' ' << off;
        }
      }
    }
    EXPECT_EQ(roll_pitch_yaw(Quaternion(std::sqrt(0.5), 0, sign * std::sqrt(0.5), 0)).roll, 0.0);
  }
}

TEST(Rotation, YawOfRollPitchYawIsTheYawOfTheBox) {
  const Box box = make_yaw_box({1, 2, 3}, {4, 2, 1}, -2.5);
  const RollPitchYaw angles = roll_pitch_yaw(box.rotation);
  EXPECT_NEAR(angles.yaw, -2.5, 1e-12);
  EXPECT_NEAR(angles.roll, 0, 1e-12);
  EXPECT_NEAR(angles.pitch, 0, 1e-12);
}

TEST(Rotation, TheSymmetriesAreTheRotationGroupOfTheCube) {
  const auto all = symmetry_rotations(BoxSymmetry::kFrame);
  ASSERT_EQ(all.size(), 24u);
  const auto index_of = [&](const Quaternion& q) {
    int found = -1;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (rotation_distance(all[i], q) > 1e-9) continue;
      EXPECT_EQ(found, -1) << "two symmetries are equal";
      found = static_cast<int>(i);
    }
    return found;
  };
  for (const Quaternion& a : all) {
    EXPECT_GE(index_of(a.conjugate()), 0);
    for (const Quaternion& b : all) EXPECT_GE(index_of(a * b), 0);
  }
  EXPECT_EQ(symmetry_rotations(BoxSymmetry::kNone).size(), 1u);
  EXPECT_EQ(symmetry_rotations(BoxSymmetry::kHalfTurns).size(), 4u);
}

RC_GTEST_PROP(Rotation, EquivalentBoxesFillTheSameSpace, ()) {
  const Box box = *any_box();
  const auto all = equivalent_boxes(box);
  for (std::size_t i = 0; i < all.size(); ++i) {
    RC_ASSERT(same_space(box, all[i], 1e-12));
    RC_ASSERT(std::abs(volume(all[i]) - volume(box)) < 1e-12 * volume(box));
    for (std::size_t j = 0; j < i; ++j) {
      RC_ASSERT(rotation_distance(all[i].rotation, all[j].rotation) > 1.0);
    }
    if (i < 4) RC_ASSERT((all[i].size - box.size).norm() < 1e-12);
  }
}

RC_GTEST_PROP(Rotation, TheNearestEquivalentIsNearestOfAll, ()) {
  const Box box = *any_box();
  const Quaternion reference = *any_rotation();
  const Box near = nearest_equivalent(box, reference);
  RC_ASSERT(same_space(box, near, 1e-12));
  double least = kPi;
  for (const Box& other : equivalent_boxes(box)) {
    least = std::min(least, rotation_distance(other.rotation, reference));
  }
  RC_ASSERT(std::abs(rotation_distance(near.rotation, reference) - least) < 1e-9);
  RC_ASSERT(least < 1.0962);
  RC_ASSERT(std::abs(rotation_distance(box.rotation, reference, BoxSymmetry::kFrame) - least) <
            1e-9);
  const Box same_sizes = nearest_equivalent(box, reference, BoxSymmetry::kHalfTurns);
  RC_ASSERT(same_space(box, same_sizes, 1e-12));
  RC_ASSERT((same_sizes.size - box.size).norm() < 1e-12);
}

RC_GTEST_PROP(Rotation, DistanceIsAMetricThatSignsAndSymmetriesDoNotChange, ()) {
  const Quaternion a = *any_rotation();
  const Quaternion b = *any_rotation();
  const Quaternion c = *any_rotation();
  const Quaternion negated(-a.w(), -a.x(), -a.y(), -a.z());
  RC_ASSERT(rotation_distance(a, negated) < 1e-12);
  for (const BoxSymmetry symmetry :
       {BoxSymmetry::kNone, BoxSymmetry::kHalfTurns, BoxSymmetry::kFrame}) {
    const double ab = rotation_distance(a, b, symmetry);
    RC_ASSERT(std::abs(ab - rotation_distance(b, a, symmetry)) < 1e-12);
    RC_ASSERT(ab <= rotation_distance(a, c, symmetry) + rotation_distance(c, b, symmetry) + 1e-12);
    for (const Quaternion& renaming : symmetry_rotations(symmetry)) {
      RC_ASSERT(rotation_distance(a, a * renaming, symmetry) < 1e-12);
    }
  }
}

TEST(Rotation, SmallDistancesKeepTheirDigits) {
  for (const double angle : {1e-3, 1e-8, 1e-12}) {
    const Quaternion turn(AngleAxisd(angle, Vector3d(1, 2, 3).normalized()));
    EXPECT_NEAR(rotation_distance(Quaternion::Identity(), turn), angle, 1e-6 * angle);
  }
}

RC_GTEST_PROP(Rotation, TheAxisAlignedHullIsTheHullOfTheCorners, ()) {
  const Box box = *any_box();
  Eigen::AlignedBox3d expected;
  for (const Vector3d& corner : corners(box)) expected.extend(corner);
  const Eigen::AlignedBox3d hull = axis_aligned_hull(box);
  RC_ASSERT((hull.min() - expected.min()).norm() < 1e-12);
  RC_ASSERT((hull.max() - expected.max()).norm() < 1e-12);
}

RC_GTEST_PROP(Rotation, TransformMovesEveryCornerAndContainsFollows, ()) {
  const Box box = *any_box();
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  move.linear() = (*any_rotation()).toRotationMatrix();
  move.translation() = *vector_between(-5, 5);
  const Box moved = transformed(box, move);
  const auto before = corners(box);
  const auto after = corners(moved);
  for (int i = 0; i < 8; ++i) RC_ASSERT((move * before[i] - after[i]).norm() < 1e-11);
  const Vector3d unit = *vector_between(-0.6, 0.6);
  const Vector3d point = box.center + box.rotation * unit.cwiseProduct(box.size);
  const bool inside = unit.cwiseAbs().maxCoeff() <= 0.5;
  RC_ASSERT(contains(box, point, 1e-9) == inside);
  RC_ASSERT(contains(moved, move * point, 1e-9) == inside);
}

}  // namespace
