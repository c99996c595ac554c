#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "arbox/geometry/internal/overlap_engine.h"
#include "arbox/geometry/overlap.h"
#include "arbox/plugins/cgal/exact_intersection.h"
#include "geometry/overlap_pairs.h"

namespace {

using namespace arbox;
using namespace arbox::geometry;
using arbox::testing::BoxPair;
using arbox::testing::PairFamily;

constexpr int kShards = 4;
constexpr int kRandomPairs = 10000;
constexpr int kDegeneratePairs = 500;

std::vector<SimdLevel> available_levels() {
  std::vector<SimdLevel> levels;
  for (const SimdLevel level : {SimdLevel::kScalar, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (level <= simd_level()) levels.push_back(level);
  }
  return levels;
}

std::string text(const Box& box) {
  std::ostringstream out;
  out.precision(17);
  out << box.center.transpose() << " | " << box.size.transpose() << " | "
      << box.rotation.coeffs().transpose() << " (x y z w)";
  return out.str();
}

// Largest error over all levels, as a share of the smaller volume.
void expect_exact(const PairFamily& family, int begin, int end) {
  double worst = 0.0;
  int overlapping = 0;
  for (int i = begin; i < end; ++i) {
    const BoxPair pair = family.make(RandomStream(17, i, 0));
    const double expected = arbox::cgal::exact_intersection(pair.first, pair.second);
    const double smaller = std::min(volume(pair.first), volume(pair.second));
    overlapping += expected > 0.0;
    for (const SimdLevel level : available_levels()) {
      const double got =
          internal::overlap_at(level, pair.first, pair.second, {.measure = Overlap::kIntersection});
      const double error = std::abs(got - expected) / smaller;
      worst = std::max(worst, error);
      ASSERT_LE(error, 1e-9) << family.name << " pair " << i << " at " << to_string(level)
                             << ": expected " << expected << ", got " << got << "\n"
                             << text(pair.first) << "\n"
                             << text(pair.second);
      const double iou = internal::overlap_at(level, pair.first, pair.second, {});
      ASSERT_TRUE(iou >= 0.0 && iou <= 1.0) << iou;
    }
  }
  ::testing::Test::RecordProperty("worst_error", std::to_string(worst * 1e15) + "e-15");
  ::testing::Test::RecordProperty("overlapping", overlapping);
}

class RandomPairs : public ::testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(RandomPairs, AgreeWithExactArithmetic) {
  const auto [family, shard] = GetParam();
  const int size = kRandomPairs / kShards;
  expect_exact(arbox::testing::random_families()[family], shard * size, (shard + 1) * size);
}

INSTANTIATE_TEST_SUITE_P(
    Overlap, RandomPairs, ::testing::Combine(::testing::Range(0, 3), ::testing::Range(0, kShards)),
    [](const auto& instance) {
      return arbox::testing::random_families()[std::get<0>(instance.param)].name + "Shard" +
             std::to_string(std::get<1>(instance.param));
    });

class DegeneratePairs : public ::testing::TestWithParam<int> {};

TEST_P(DegeneratePairs, AgreeWithExactArithmetic) {
  expect_exact(arbox::testing::degenerate_families()[GetParam()], 0, kDegeneratePairs);
}

INSTANTIATE_TEST_SUITE_P(
    Overlap, DegeneratePairs,
    ::testing::Range(0, static_cast<int>(arbox::testing::degenerate_families().size())),
    [](const auto& instance) {
      return arbox::testing::degenerate_families()[instance.param].name;
    });

}  // namespace
