#include "arbox/evaluation/ranking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/base/random.h"

namespace arbox::evaluation {
namespace {

struct Case {
  std::vector<double> scores;
  std::vector<bool> positive;
  std::vector<double> other;
};

// Few distinct values, so that most cases are full of ties.
Case random_case(std::uint64_t object) {
  const RandomStream stream(7, object, 0);
  Case result;
  const std::uint32_t count = 2 + stream.below(0, 40);
  const std::uint32_t values = 2 + stream.below(1, 30);
  for (std::uint32_t i = 0; i < count; ++i) {
    result.scores.push_back(stream.below(10 + 3 * i, values));
    result.positive.push_back(stream.below(11 + 3 * i, 3) == 0);
    result.other.push_back(stream.below(12 + 3 * i, values) - 0.5 * result.scores.back());
  }
  return result;
}

TEST(RocAuc, EqualsTheShareOfPairsInOrder) {
  int defined = 0;
  for (std::uint64_t object = 0; object < 500; ++object) {
    const Case c = random_case(object);
    double in_order = 0.0, pairs = 0.0;
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      for (std::size_t j = 0; j < c.scores.size(); ++j) {
        if (!c.positive[i] || c.positive[j]) continue;
        pairs += 1.0;
        in_order += c.scores[i] > c.scores[j] ? 1.0 : (c.scores[i] == c.scores[j] ? 0.5 : 0.0);
      }
    }
    const auto auc = roc_auc(c.scores, c.positive);
    ASSERT_EQ(auc.has_value(), pairs > 0.0);
    if (!auc) continue;
    ++defined;
    EXPECT_NEAR(*auc, in_order / pairs, 1e-12);
  }
  EXPECT_GT(defined, 400);
}

TEST(RocAuc, HandCases) {
  EXPECT_EQ(*roc_auc(std::vector{0.1, 0.2, 0.8, 0.9}, {false, false, true, true}), 1.0);
  EXPECT_EQ(*roc_auc(std::vector{0.1, 0.2, 0.8, 0.9}, {true, true, false, false}), 0.0);
  EXPECT_EQ(*roc_auc(std::vector{1.0, 1.0, 1.0}, {true, false, false}), 0.5);
}

TEST(RocAuc, IsUndefinedWithoutBothKinds) {
  EXPECT_FALSE(roc_auc(std::vector<double>{}, {}));
  EXPECT_FALSE(roc_auc(std::vector{0.5, 0.6}, {true, true}));
  EXPECT_FALSE(roc_auc(std::vector{0.5, 0.6}, {false, false}));
}

TEST(ExpectedRocAuc, EqualsTheExpectedShareOfPairsInOrder) {
  int defined = 0;
  for (std::uint64_t object = 0; object < 500; ++object) {
    const Case c = random_case(object);
    const RandomStream stream(8, object, 0);
    std::vector<double> chances;
    for (std::uint32_t i = 0; i < c.scores.size(); ++i) {
      chances.push_back(std::clamp(1.4 * stream.uniform(i) - 0.2, 0.0, 1.0));
    }
    double in_order = 0.0, pairs = 0.0;
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      for (std::size_t j = 0; j < c.scores.size(); ++j) {
        if (i == j) continue;
        const double pair = chances[i] * (1.0 - chances[j]);
        pairs += pair;
        in_order +=
            pair * (c.scores[i] > c.scores[j] ? 1.0 : (c.scores[i] == c.scores[j] ? 0.5 : 0.0));
      }
    }
    const auto auc = expected_roc_auc(c.scores, chances);
    ASSERT_EQ(auc.has_value(), pairs > 1e-9);
    if (!auc) continue;
    ++defined;
    EXPECT_NEAR(*auc, in_order / pairs, 1e-9);
  }
  EXPECT_GT(defined, 400);
}

TEST(ExpectedRocAuc, OfSureThingsIsTheRocAuc) {
  for (std::uint64_t object = 0; object < 200; ++object) {
    const Case c = random_case(object);
    const std::vector<double> chances(c.positive.begin(), c.positive.end());
    const auto auc = roc_auc(c.scores, c.positive);
    const auto expected = expected_roc_auc(c.scores, chances);
    ASSERT_EQ(auc.has_value(), expected.has_value());
    if (auc) {
      EXPECT_NEAR(*auc, *expected, 1e-12);
    }
  }
}

TEST(ExpectedRocAuc, NoRankingBeatsTheChanceItself) {
  for (std::uint64_t object = 0; object < 200; ++object) {
    const RandomStream stream(9, object, 0);
    std::vector<double> chances, scores;
    for (std::uint32_t i = 0; i < 50; ++i) {
      chances.push_back(stream.uniform(2 * i));
      scores.push_back(chances.back() + stream.uniform(2 * i + 1));
    }
    EXPECT_GT(*expected_roc_auc(chances, chances), *expected_roc_auc(scores, chances));
  }
}

TEST(MeanRanks, CountSmallerAndHalfOfEqual) {
  for (std::uint64_t object = 0; object < 200; ++object) {
    const Case c = random_case(object);
    const std::vector<double> ranks = mean_ranks(c.scores);
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      double rank = 0.5;
      for (const double other : c.scores) {
        rank += other < c.scores[i] ? 1.0 : (other == c.scores[i] ? 0.5 : 0.0);
      }
      EXPECT_EQ(ranks[i], rank);
    }
  }
}

TEST(Spearman, EqualsPearsonOfRanks) {
  for (std::uint64_t object = 0; object < 500; ++object) {
    const Case c = random_case(object);
    const std::vector<double> x = mean_ranks(c.scores), y = mean_ranks(c.other);
    const double n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sx += x[i], sy += y[i], sxx += x[i] * x[i], syy += y[i] * y[i], sxy += x[i] * y[i];
    }
    const double spread = (n * sxx - sx * sx) * (n * syy - sy * sy);
    const auto correlation = spearman_correlation(c.scores, c.other);
    ASSERT_EQ(correlation.has_value(), spread > 0.0);
    if (correlation) {
      EXPECT_NEAR(*correlation, (n * sxy - sx * sy) / std::sqrt(spread), 1e-12);
    }
  }
}

TEST(Spearman, SeesOnlyTheOrder) {
  const std::vector<double> x = {-2.0, -1.0, 0.5, 3.0, 8.0};
  std::vector<double> rising, falling;
  for (const double value : x) {
    rising.push_back(std::exp(value));
    falling.push_back(-value * value * value);
  }
  EXPECT_DOUBLE_EQ(*spearman_correlation(x, rising), 1.0);
  EXPECT_DOUBLE_EQ(*spearman_correlation(x, falling), -1.0);
  // 1 - 6 sum(d^2) / (n (n^2 - 1)) of the ranks 1 2 3 4 5 and 2 1 4 3 5.
  EXPECT_DOUBLE_EQ(*spearman_correlation(x, std::vector{2.0, 1.0, 4.0, 3.0, 5.0}), 0.8);
}

TEST(Spearman, IsUndefinedForConstantsAndSinglePairs) {
  EXPECT_FALSE(spearman_correlation(std::vector<double>{}, std::vector<double>{}));
  EXPECT_FALSE(spearman_correlation(std::vector{1.0}, std::vector{2.0}));
  EXPECT_FALSE(spearman_correlation(std::vector{1.0, 1.0, 1.0}, std::vector{1.0, 2.0, 3.0}));
}

TEST(ExpectedRocAuc, RefusesWhatIsNoChance) {
  EXPECT_THROW(expected_roc_auc(std::vector{1.0}, std::vector{1.5}), InvalidArgument);
  EXPECT_THROW(expected_roc_auc(std::vector{1.0}, std::vector{-0.1}), InvalidArgument);
  EXPECT_THROW(expected_roc_auc(std::vector{1.0, 2.0}, std::vector{0.5}), InvalidArgument);
  EXPECT_FALSE(expected_roc_auc(std::vector<double>{}, std::vector<double>{}));
  EXPECT_FALSE(expected_roc_auc(std::vector{1.0}, std::vector{0.5})) << "a single box has no pair";
}

TEST(Ranking, RefusesUnequalLengthsAndNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(roc_auc(std::vector{1.0, 2.0}, {true}), InvalidArgument);
  EXPECT_THROW(roc_auc(std::vector{1.0, nan}, {true, false}), InvalidArgument);
  EXPECT_THROW(expected_roc_auc(std::vector{1.0, nan}, std::vector{0.5, 0.5}), InvalidArgument);
  EXPECT_THROW(expected_roc_auc(std::vector{1.0, 2.0}, std::vector{0.5, nan}), InvalidArgument);
  EXPECT_THROW(spearman_correlation(std::vector{1.0, 2.0}, std::vector{1.0}), InvalidArgument);
  EXPECT_THROW(spearman_correlation(std::vector{1.0, nan}, std::vector{1.0, 2.0}), InvalidArgument);
}

}  // namespace
}  // namespace arbox::evaluation
