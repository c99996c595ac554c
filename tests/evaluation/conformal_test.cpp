#include "arbox/evaluation/conformal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "support/statistics.h"

namespace arbox::evaluation {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ConformalRank, NeedsNoExtraRankWhereTheProductIsWhole) {
  EXPECT_EQ(conformal_rank(0, 0.5), 1);
  for (int n = 1; n < 2000; ++n) {
    for (int percent = 1; percent < 100; ++percent) {
      const int exact = ((n + 1) * percent + 99) / 100;
      ASSERT_EQ(conformal_rank(n, percent / 100.0), exact) << n << " " << percent;
    }
  }
}

TEST(ConformalObjectsNeeded, IsTheLeastNumberThatCanPromise) {
  EXPECT_EQ(conformal_objects_needed(0.5), 1);
  EXPECT_EQ(conformal_objects_needed(0.9), 9);
  EXPECT_EQ(conformal_objects_needed(0.95), 19);
  EXPECT_EQ(conformal_objects_needed(0.99), 99);
  for (int thousandth = 1; thousandth < 1000; ++thousandth) {
    const double p = thousandth / 1000.0;
    const auto n = conformal_objects_needed(p);
    EXPECT_LE(conformal_rank(n, p), n);
    if (n > 0) {
      EXPECT_GT(conformal_rank(n - 1, p), n - 1);
    }
  }
}

TEST(ConformalThreshold, IsThatOrderStatistic) {
  for (std::uint64_t object = 0; object < 200; ++object) {
    const RandomStream stream(3, object, 0);
    std::vector<double> scores(1 + stream.below(0, 60));
    for (std::uint32_t i = 0; i < scores.size(); ++i) scores[i] = stream.below(1 + i, 12);
    const double p = stream.uniform(1000, 0.01, 0.99);
    std::vector<double> sorted = scores;
    std::sort(sorted.begin(), sorted.end());
    const auto rank =
        static_cast<std::size_t>(std::ceil((static_cast<double>(scores.size()) + 1.0) * p));
    EXPECT_EQ(conformal_threshold(scores, p), rank > sorted.size() ? kInfinity : sorted[rank - 1]);
  }
}

TEST(ConformalThreshold, IsInfiniteForTooFewOrNeverRightScores) {
  EXPECT_EQ(conformal_threshold({}, 0.5), kInfinity);
  EXPECT_EQ(conformal_threshold(std::vector<double>(8, 1.0), 0.9), kInfinity);
  EXPECT_EQ(conformal_threshold(std::vector<double>(9, 1.0), 0.9), 1.0);
  EXPECT_EQ(conformal_threshold(std::vector{1.0, kInfinity, kInfinity}, 0.5), kInfinity);
  EXPECT_EQ(conformal_threshold(std::vector{1.0, 2.0, kInfinity}, 0.5), 2.0);
}

TEST(ConformalThreshold, RefusesBadInput) {
  const std::vector<double> scores = {1.0, 2.0};
  for (const double p : {0.0, 1.0, -0.1, 1.1, std::nan("")}) {
    EXPECT_THROW(conformal_threshold(scores, p), InvalidArgument);
  }
  EXPECT_THROW(conformal_threshold(std::vector{1.0, std::nan("")}, 0.5), InvalidArgument);
}

class ConformalCoverage : public ::testing::TestWithParam<double> {};

// Heavy-tailed with ties at a floor: nothing that the promise may lean on.
double skewed_score(const RandomStream& stream, std::uint32_t i) {
  return std::max(0.1, std::exp(2.0 * stream.normal(i)));
}

// Exchangeability without sampling error: each object in turn is the new one.
TEST_P(ConformalCoverage, HoldsExactlyWhenEachObjectIsLeftOut) {
  const double p = GetParam();
  for (const std::uint32_t objects : {2u, 5u, 17u, 40u, 101u}) {
    const RandomStream stream(5, objects, 0);
    std::vector<double> scores(objects);
    for (std::uint32_t i = 0; i < objects; ++i) scores[i] = skewed_score(stream, i);
    int covered = 0;
    for (std::uint32_t i = 0; i < objects; ++i) {
      std::vector<double> others;
      for (std::uint32_t j = 0; j < objects; ++j) {
        if (j != i) others.push_back(scores[j]);
      }
      covered += scores[i] <= conformal_threshold(others, p);
    }
    EXPECT_GE(covered, p * objects - 1e-9) << objects;
  }
}

TEST_P(ConformalCoverage, ReachesThePromiseOverTwentySplits) {
  const double p = GetParam();
  constexpr std::uint32_t kObjects = 4000;
  constexpr int kSplits = 20;
  const RandomStream data(1, 0, 0);
  double sum = 0.0, sum_of_squares = 0.0;
  std::int64_t covered = 0, tested = 0;
  for (int split = 0; split < kSplits; ++split) {
    const RandomStream chance(1, static_cast<std::uint64_t>(split), 1);
    std::vector<double> calibration, fresh;
    for (std::uint32_t i = 0; i < kObjects; ++i) {
      (chance.below(i, 2) ? calibration : fresh).push_back(skewed_score(data, i));
    }
    const double threshold = conformal_threshold(calibration, p);
    const auto inside =
        std::count_if(fresh.begin(), fresh.end(), [&](double score) { return score <= threshold; });
    const double coverage = static_cast<double>(inside) / static_cast<double>(fresh.size());
    sum += coverage;
    sum_of_squares += coverage * coverage;
    covered += inside;
    tested += static_cast<std::int64_t>(fresh.size());
  }
  const double mean = sum / kSplits;
  const double deviation = std::sqrt((sum_of_squares / kSplits - mean * mean) / (kSplits - 1));
  EXPECT_GE(mean, p - deviation);
  EXPECT_LE(mean, p + 0.02);
  EXPECT_GE(testing::binomial_lower_tail(covered, tested, p), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Probabilities, ConformalCoverage, ::testing::Values(0.5, 0.8, 0.9, 0.95));

}  // namespace
}  // namespace arbox::evaluation
