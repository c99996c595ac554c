// Links CGAL's GPL packages: a test program, never installed.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/optimal_bounding_box.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "arbox/geometry/enclosing_box.h"
#include "support/box_samples.h"

namespace {

using namespace arbox::geometry;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

double volume_by_cgal(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Kernel::Point_3> converted;
  for (const Eigen::Vector3d& p : points) converted.emplace_back(p.x(), p.y(), p.z());
  std::array<Kernel::Point_3, 8> corners;
  CGAL::oriented_bounding_box(converted, corners, CGAL::parameters::use_convex_hull(true));
  const auto length = [&](int i) {
    return std::sqrt(CGAL::to_double(CGAL::squared_distance(corners[0], corners[i])));
  };
  return length(1) * length(3) * length(5);
}

TEST(MinimumVolumeBox, IsAsSmallAsTheOneOfCgal) {
  std::mt19937_64 random(19);
  std::normal_distribution<double> normal;
  constexpr int kTrials = 40;
  int as_small = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector3d size(1 + trial % 5, 1, 0.3 + 0.1 * (trial % 7));
    const Quaternion turn = arbox::testing::random_rotation(random, false);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 6 + 8 * trial; ++i) {
      const Eigen::Vector3d p(normal(random), normal(random), normal(random));
      points.push_back(turn * p.cwiseProduct(size));
    }
    const double ratio = volume(*minimum_volume_box(points)) / volume_by_cgal(points);
    EXPECT_LE(ratio, 1.002) << trial;
    as_small += ratio <= 1 + 1e-6;
  }
  EXPECT_GE(as_small, 0.85 * kTrials);
}

}  // namespace
