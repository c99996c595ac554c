#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <numbers>

#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"
#include "arbox/geometry/rotation.h"
#include "support/random_boxes.h"

namespace {

using namespace arbox;
using namespace arbox::geometry;
using arbox::testing::any_rotation;
using arbox::testing::number_between;
using arbox::testing::vector_between;
using Eigen::Vector3d;

constexpr OverlapOptions kVolume{.measure = Overlap::kIntersection};
constexpr OverlapOptions kIog{.measure = Overlap::kIog};

// Close enough together that most pairs overlap; half of them yaw-only.
Box near_box() {
  Box box{.center = *vector_between(-1.5, 1.5), .size = *vector_between(0.1, 4.0)};
  if (*rc::gen::arbitrary<bool>()) {
    box.rotation = make_yaw_box({0, 0, 0}, {1, 1, 1}, *number_between(-4.0, 4.0)).rotation;
  } else {
    box.rotation = *any_rotation();
  }
  return box;
}

double smaller_volume(const Box& a, const Box& b) { return std::min(volume(a), volume(b)); }

bool close(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }

RC_GTEST_PROP(OverlapProperty, IntersectionAndIouAreSymmetric, ()) {
  const Box a = near_box(), b = near_box();
  RC_ASSERT(close(overlap(a, b, kVolume), overlap(b, a, kVolume), 1e-13 * smaller_volume(a, b)));
  RC_ASSERT(close(overlap(a, b), overlap(b, a), 1e-13));
}

RC_GTEST_PROP(OverlapProperty, MeasuresStayInBoundsAndAgreeWithEachOther, ()) {
  const Box a = near_box(), b = near_box();
  const double shared = overlap(a, b, kVolume), iou = overlap(a, b), iog = overlap(a, b, kIog);
  RC_ASSERT(shared >= 0.0 && shared <= smaller_volume(a, b));
  RC_ASSERT(iou >= 0.0 && iou <= 1.0 && iog >= iou && iog <= 1.0);
  RC_ASSERT(close(iou, shared / (volume(a) + volume(b) - shared), 1e-14));
  RC_ASSERT(close(iog, shared / volume(b), 1e-14));
}

RC_GTEST_PROP(OverlapProperty, RigidMotionChangesNothing, ()) {
  const Box a = near_box(), b = near_box();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = (*any_rotation()).toRotationMatrix();
  motion.translation() = *vector_between(-100.0, 100.0);
  RC_ASSERT(close(overlap(transformed(a, motion), transformed(b, motion), kVolume),
                  overlap(a, b, kVolume), 1e-11 * smaller_volume(a, b)));
}

RC_GTEST_PROP(OverlapProperty, YawBoxesAgreeWithTheGeneralMethod, ()) {
  const Box a =
      make_yaw_box(*vector_between(-1, 1), *vector_between(0.1, 4), *number_between(-4, 4));
  const Box b =
      make_yaw_box(*vector_between(-1, 1), *vector_between(0.1, 4), *number_between(-4, 4));
  // Turned on their sides, the same boxes take the way of free rotations.
  const Eigen::Isometry3d side(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()));
  RC_ASSERT(close(overlap(transformed(a, side), transformed(b, side), kVolume),
                  overlap(a, b, kVolume), 1e-12 * smaller_volume(a, b)));
}

RC_GTEST_PROP(OverlapProperty, GrowingABoxNeverShrinksTheIntersection, ()) {
  const Box a = near_box(), b = near_box();
  Box grown = b;
  const int axis = *rc::gen::inRange(0, 3);
  grown.size[axis] += *number_between(0.0, 2.0);
  RC_ASSERT(overlap(a, grown, kVolume) >= overlap(a, b, kVolume) - 1e-13 * smaller_volume(a, b));
}

RC_GTEST_PROP(OverlapProperty, ScaleIsTheCubeOfTheVolume, ()) {
  Box a = near_box(), b = near_box();
  const double before = overlap(a, b, kVolume);
  const double scale = std::pow(10.0, *number_between(-9.0, 9.0));
  for (Box* box : {&a, &b}) {
    box->center *= scale;
    box->size *= scale;
  }
  RC_ASSERT(close(overlap(a, b, kVolume) / std::pow(scale, 3), before,
                  1e-12 * smaller_volume(a, b) / std::pow(scale, 3)));
}

RC_GTEST_PROP(OverlapProperty, HalvesAddUpToTheWhole, ()) {
  const Box a = near_box(), b = near_box();
  const int axis = *rc::gen::inRange(0, 3);
  const double share = *number_between(0.01, 0.99);
  Box low = b, high = b;
  low.size[axis] *= share;
  high.size[axis] *= 1.0 - share;
  low.center -= b.rotation * Vector3d(0.5 * (1.0 - share) * b.size[axis] * Vector3d::Unit(axis));
  high.center += b.rotation * Vector3d(0.5 * share * b.size[axis] * Vector3d::Unit(axis));
  RC_ASSERT(close(overlap(a, low, kVolume) + overlap(a, high, kVolume), overlap(a, b, kVolume),
                  1e-12 * smaller_volume(a, b)));
}

RC_GTEST_PROP(OverlapProperty, EquivalentBoxesOverlapOthersAlike, ()) {
  const Box a = near_box(), b = near_box();
  const Box renamed = equivalent_boxes(b)[*rc::gen::inRange(0, 24)];
  RC_ASSERT(
      close(overlap(a, renamed, kVolume), overlap(a, b, kVolume), 1e-12 * smaller_volume(a, b)));
}

RC_GTEST_PROP(OverlapProperty, AgreesWithMonteCarlo, ()) {
  const Box a = near_box(), b = near_box();
  const RandomStream stream(*rc::gen::arbitrary<std::uint64_t>(), 0, 0);
  constexpr int kPoints = 4000;
  int inside = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vector3d unit(stream.uniform(3 * i, -0.5, 0.5), stream.uniform(3 * i + 1, -0.5, 0.5),
                        stream.uniform(3 * i + 2, -0.5, 0.5));
    const Vector3d point = b.center + b.rotation * Vector3d(unit.cwiseProduct(b.size));
    inside += contains(a, point);
  }
  const double share = overlap(a, b, kIog);
  const double deviation = std::sqrt(share * (1.0 - share) / kPoints);
  RC_ASSERT(close(static_cast<double>(inside) / kPoints, share, 6.0 * deviation + 2.0 / kPoints));
}

}  // namespace
