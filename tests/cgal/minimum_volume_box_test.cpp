#include "arbox/plugins/cgal/minimum_volume_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "arbox/geometry/overlap.h"
#include "arbox/plugins/cgal/exact_intersection.h"
#include "support/box_samples.h"
#include "support/refusal.h"

namespace arbox::testing {
namespace {

using namespace geometry;
using Points = std::vector<Eigen::Vector3d>;

Points cloud(std::mt19937_64& random, int trial) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d size(1 + trial % 5, 1, 0.3 + 0.1 * (trial % 7));
  const Quaternion turn = random_rotation(random, false);
  Points points;
  for (int i = 0; i < 6 + 8 * trial; ++i) {
    const Eigen::Vector3d p(normal(random), normal(random), normal(random));
    points.push_back(turn * p.cwiseProduct(size));
  }
  return points;
}

TEST(MinimumVolumeBox, IsAsSmallByOurSearchAsByCgal) {
  std::mt19937_64 random(19);
  constexpr int kTrials = 40;
  int as_small = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Points points = cloud(random, trial);
    const auto by_cgal = cgal::minimum_volume_box(points);
    ASSERT_TRUE(by_cgal);
    for (const Eigen::Vector3d& point : points) EXPECT_TRUE(contains(*by_cgal, point, 1e-12));
    const double ratio = volume(*minimum_volume_box(points)) / volume(*by_cgal);
    EXPECT_LE(ratio, 1.002) << trial;
    EXPECT_GE(ratio, 0.9) << trial;
    as_small += ratio <= 1 + 1e-6;
  }
  EXPECT_GE(as_small, 0.85 * kTrials);
}

TEST(CgalMinimumVolumeBox, FindsABoxAgainAndTakesFlatSets) {
  std::mt19937_64 random(3);
  const Box box{
      .center = {10, -4, 2}, .size = {4.1, 1.7, 1.4}, .rotation = random_rotation(random, false)};
  const auto corner = corners(box);
  const auto found = cgal::minimum_volume_box(corner);
  ASSERT_TRUE(found);
  EXPECT_GT(overlap(*found, box), 0.9999);
  EXPECT_FALSE(cgal::minimum_volume_box(Points{}));
  const auto point = cgal::minimum_volume_box(Points{{1, 2, 3}});
  ASSERT_TRUE(point);
  EXPECT_EQ(point->center, Eigen::Vector3d(1, 2, 3));
  const auto flat = cgal::minimum_volume_box(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  ASSERT_TRUE(flat);
  EXPECT_NEAR(volume(*flat), kMinimumBoxSize, 1e-9);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal([&] { cgal::minimum_volume_box(Points{{nan, 0, 0}}); }), "no error");
}

TEST(CgalIntersection, AgreesWithOurOverlap) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-1.5, 1.5), length(0.5, 4.0);
  for (int trial = 0; trial < 60; ++trial) {
    const auto any = [&] {
      return Box{.center = {place(random), place(random), place(random)},
                 .size = {length(random), length(random), length(random)},
                 .rotation = random_rotation(random, false)};
    };
    const Box a = any(), b = any();
    const double exact = cgal::exact_intersection(a, b);
    EXPECT_NEAR(overlap(a, b, {.measure = Overlap::kIntersection}), exact,
                1e-12 * std::min(volume(a), volume(b)));
    EXPECT_NEAR(cgal::exact_intersection(a, a), volume(a), 1e-12 * volume(a));
  }
  EXPECT_NE(refusal([] { cgal::exact_intersection(Box{.size = {0, 1, 1}}, Box{}); }), "no error");
}

}  // namespace
}  // namespace arbox::testing
