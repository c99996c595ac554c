#include "arbox/geometry/quantile_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <string>

#include "arbox/base/error.h"
#include "support/box_samples.h"
#include "support/naive_quantile_box.h"
#include "support/refusal.h"

namespace {

using namespace arbox::geometry;
using namespace arbox::testing;
using arbox::InvalidArgument;
using Eigen::Vector3d;

bool same_box(const Box& a, const Box& b, double tolerance = 1e-9) {
  return holds(a, b, tolerance) && holds(b, a, tolerance);
}

TEST(Occupancy, IsTheWeightOfTheBoxesThatHoldThePoint) {
  const std::vector<Box> samples = {
      make_yaw_box({0, 0, 0}, {2, 2, 2}, 0.3), make_yaw_box({0.5, 0, 0}, {2, 2, 2}, 0),
      make_yaw_box({5, 0, 0}, {1, 1, 1}, 0), make_yaw_box({0, 0, 0}, {1, 1, 1}, 1.0)};
  EXPECT_EQ(occupancy(samples, {0, 0, 0}), 0.75);
  EXPECT_EQ(occupancy(samples, {5, 0, 0}), 0.25);
  EXPECT_EQ(occupancy(samples, {9, 0, 0}), 0.0);
  EXPECT_EQ(occupancy(samples, {5.5, 0.5, 0.5}), 0.25) << "faces belong to their box";
  const std::vector<double> weights = {1, 2, 4, 1};
  EXPECT_EQ(occupancy({.boxes = samples, .weights = weights}, {0, 0, 0}), 0.5);
  EXPECT_EQ(occupancy({.boxes = samples, .weights = weights}, {5, 0, 0}), 0.5);
}

TEST(Occupancy, AgreesWithCountingBoxByBox) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 40; ++trial) {
    const auto samples = scattered_samples(random, 1 + trial, 0.5, trial % 2 == 0);
    for (int i = 0; i < 50; ++i) {
      const Vector3d point =
          samples[0].center + 2.0 * Vector3d(normal(random), normal(random), normal(random));
      EXPECT_EQ(occupancy(samples, point), naive_occupancy(samples, point));
    }
  }
}

class QuantileBoxOfEitherKind : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Rotations, QuantileBoxOfEitherKind, ::testing::Values(true, false),
                         [](const auto& kind) { return kind.param ? "YawOnly" : "Free"; });

TEST_P(QuantileBoxOfEitherKind, EqualsAlgorithmOneWrittenDown) {
  std::mt19937_64 random(11);
  const std::vector<double> qs = {0.0, 0.1, 0.2, 0.5, 0.45, 0.3};
  for (const double spread : {0.02, 0.1, 0.2}) {
    for (std::uint64_t object = 0; object < 12; ++object) {
      const auto samples = scattered_samples(random, 64, spread, GetParam());
      const BoxSamples input{.boxes = samples, .object = object};
      const auto expected = naive_quantile_boxes(samples, qs, 4, 9, object);
      const auto result = quantile_boxes(input, qs, {.seed = 9});
      const auto points = naive_points(samples, 4, 9, object);
      const auto own_points = occupancy_points(input, {.seed = 9});
      ASSERT_EQ(points.size(), own_points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_LT((points[i] - own_points[i]).norm(), 1e-12);
      }
      for (std::size_t i = 0; i < qs.size(); ++i) {
        EXPECT_EQ(result[i].q, qs[i]);
        EXPECT_FALSE(result[i].fallback);
        EXPECT_TRUE(same_box(result[i].box, expected[i]))
            << spread << ' ' << object << ' ' << qs[i] << ' ' << volume(result[i].box) << ' '
            << volume(expected[i]);
        std::size_t above = 0;
        for (const Vector3d& p : points) above += naive_occupancy(samples, p) > qs[i];
        EXPECT_EQ(occupancy_quantile(input, qs[i], {.seed = 9}).size(), above);
      }
    }
  }
}

/// Draws from nested boxes with the given probabilities.
std::vector<Box> draws(std::mt19937_64& random, const std::vector<Box>& boxes,
                       const std::vector<double>& weights, int count) {
  std::discrete_distribution<int> index(weights.begin(), weights.end());
  std::vector<Box> result;
  for (int i = 0; i < count; ++i) result.push_back(boxes[index(random)]);
  return result;
}

double contained_weight(const Box& outer, const std::vector<Box>& boxes,
                        const std::vector<double>& weights) {
  double inside = 0, total = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const double weight = weights.empty() ? 1.0 : weights[i];
    total += weight;
    if (holds(outer, boxes[i], 1e-9)) inside += weight;
  }
  return inside / total;
}

std::vector<double> random_quantiles(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> qs = {0.0, 0.1, 0.2, 0.25, 0.5, 0.75, 0.9, 0.99};
  for (int i = 0; i < 4; ++i) qs.push_back(unit(random));
  return qs;
}

TEST_P(QuantileBoxOfEitherKind, ContainsTheSamplesOfOrderedDistributions) {
  std::mt19937_64 random(23);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto boxes = nested_boxes(random, 1 + trial % 9, GetParam());
    std::vector<double> weights;
    for (std::size_t i = 0; i < boxes.size(); ++i) weights.push_back(0.01 + unit(random));
    const auto qs = random_quantiles(random);
    const QuantileOptions options{.points_per_box = trial % 12, .refine = trial % 50 == 0};
    for (const auto& q : quantile_boxes(BoxSamples{boxes, weights}, qs, options)) {
      EXPECT_FALSE(q.fallback);
      EXPECT_GE(contained_weight(q.box, boxes, weights), 1.0 - q.q - 1e-12) << trial;
    }
    const auto drawn = draws(random, boxes, weights, 64);
    for (const auto& q : quantile_boxes(drawn, qs, options)) {
      EXPECT_FALSE(q.fallback);
      EXPECT_GE(contained_weight(q.box, drawn, {}), 1.0 - q.q) << trial << " q " << q.q;
    }
  }
}

/// P(X <= successes) of a binomial distribution.
double binomial_below(int successes, int trials, double probability) {
  double sum = 0;
  for (int i = 0; i <= successes; ++i) {
    sum +=
        std::exp(std::lgamma(trials + 1.0) - std::lgamma(i + 1.0) - std::lgamma(trials - i + 1.0) +
                 i * std::log(probability) + (trials - i) * std::log1p(-probability));
  }
  return sum;
}

TEST_P(QuantileBoxOfEitherKind, FreshDrawsOfOrderedDistributionsAreContained) {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const std::vector<double> qs = {0.1, 0.3, 0.5, 0.8};
  std::vector<int> contained(qs.size());
  constexpr int kTrials = 1000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto boxes = nested_boxes(random, 2 + trial % 8, GetParam());
    std::vector<double> weights;
    for (std::size_t i = 0; i < boxes.size(); ++i) weights.push_back(0.05 + unit(random));
    const auto result = quantile_boxes(BoxSamples{boxes, weights}, qs, {.points_per_box = 8});
    const Box fresh = draws(random, boxes, weights, 1).front();
    for (std::size_t i = 0; i < qs.size(); ++i) contained[i] += holds(result[i].box, fresh, 1e-9);
  }
  for (std::size_t i = 0; i < qs.size(); ++i) {
    EXPECT_GT(binomial_below(contained[i], kTrials, 1.0 - qs[i]), 1e-3)
        << contained[i] << " at q = " << qs[i];
  }
}

TEST(QuantileBox, TheStackedBoxesOfThePaper) {
  constexpr double kHeight = 1.2;
  std::vector<Box> samples;
  for (int i = 1; i <= 4; ++i) {
    samples.push_back(make_yaw_box({3, -2, kHeight / i / 2}, {0.6, 0.4, kHeight / i}, 0.4));
  }
  // O(x) is 1, 3/4, 1/2, 1/4 up to the heights H/4, H/3, H/2, H.
  const std::vector<std::pair<double, int>> expected = {
      {0.0, 1}, {0.1, 1}, {0.25, 2}, {0.4, 2}, {0.5, 3}, {0.6, 3}, {0.75, 4}, {0.9, 4}, {0.999, 4}};
  for (const auto& [q, i] : expected) {
    const auto result = quantile_boxes(samples, std::vector{q}).front();
    EXPECT_TRUE(same_box(result.box, samples[i - 1])) << q << ' ' << result.box.size.transpose();
    EXPECT_FALSE(result.fallback);
  }
}

TEST(QuantileBox, WithoutCornersTheFacesAreNotReached) {
  const std::vector<Box> samples = {make_yaw_box({0, 0, 0}, {2, 2, 2}, 0)};
  const std::vector<double> qs = {0.5};
  EXPECT_LT(quantile_boxes(samples, qs, {.corners = false})[0].box.size.maxCoeff(), 2.0);
  const auto jittered = quantile_boxes(samples, qs, {.placement = "jittered_grid"})[0];
  EXPECT_TRUE(same_box(jittered.box, samples[0])) << "points outside have occupancy 0";
}

TEST_P(QuantileBoxOfEitherKind, GrowsAsQFallsAndHoldsEverySampleAtZero) {
  std::mt19937_64 random(41);
  std::vector<double> qs;
  for (int i = 0; i <= 20; ++i) qs.push_back(i / 20.0);
  for (int trial = 0; trial < 30; ++trial) {
    const auto samples = scattered_samples(random, 40, 0.05 * trial, GetParam());
    const auto result = quantile_boxes(samples, qs);
    for (const Box& sample : samples) EXPECT_TRUE(holds(result[0].box, sample, 1e-9));
    for (std::size_t i = 1; i < qs.size(); ++i) {
      EXPECT_LE(volume(result[i].box), volume(result[i - 1].box));
      EXPECT_GE(result[i].fallback, result[i - 1].fallback) << "fallback only above some q";
      EXPECT_NO_THROW(require_valid(result[i].box, "test"));
      EXPECT_TRUE(!GetParam() || is_yaw_only(result[i].box));
    }
    EXPECT_TRUE(result[20].fallback) << "no occupancy is above 1";
  }
}

TEST_P(QuantileBoxOfEitherKind, RefinementNeverGrowsAndKeepsThePoints) {
  std::mt19937_64 random(43);
  const std::vector<double> qs = {0.05, 0.3, 0.7};
  double gain = 0;
  for (int trial = 0; trial < 15; ++trial) {
    const auto samples = scattered_samples(random, 12, 0.3, GetParam());
    const QuantileOptions plain{.points_per_box = 27};
    const QuantileOptions refined{.points_per_box = 27, .refine = true};
    const auto before = quantile_boxes(samples, qs, plain);
    const auto after = quantile_boxes(samples, qs, refined);
    for (std::size_t i = 0; i < qs.size(); ++i) {
      EXPECT_LE(volume(after[i].box), volume(before[i].box));
      gain += 1 - volume(after[i].box) / volume(before[i].box);
      EXPECT_TRUE(!GetParam() || is_yaw_only(after[i].box));
      if (after[i].fallback) continue;
      for (const Vector3d& p : occupancy_quantile({.boxes = samples}, qs[i], plain)) {
        EXPECT_TRUE(contains(after[i].box, p, 1e-9));
      }
    }
  }
  EXPECT_GT(gain, 0.1) << "the search should find something";
}

TEST(QuantileBox, AnObjectsResultDependsOnItsOwnNumberOnly) {
  std::mt19937_64 random(47);
  std::vector<std::vector<Box>> storage;
  for (int i = 0; i < 9; ++i) storage.push_back(scattered_samples(random, 20 + i, 0.2, i % 2));
  std::vector<BoxSamples> objects;
  for (std::size_t i = 0; i < storage.size(); ++i) {
    objects.push_back({.boxes = storage[i], .object = 100 + i});
  }
  const std::vector<double> qs = {0.2, 0.8};
  const auto alone = quantile_boxes(objects, qs, {.seed = 3, .threads = 1});
  const auto threaded = quantile_boxes(objects, qs, {.seed = 3, .threads = 4});
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto single = quantile_boxes(objects[i], qs, {.seed = 3});
    for (std::size_t j = 0; j < qs.size(); ++j) {
      EXPECT_TRUE(equal_bytes(alone[i][j].box, threaded[i][j].box));
      EXPECT_TRUE(equal_bytes(alone[i][j].box, single[j].box));
    }
  }
  const auto reseeded = quantile_boxes(objects, qs, {.seed = 4});
  EXPECT_FALSE(equal_bytes(alone[0][1].box, reseeded[0][1].box));
  EXPECT_TRUE(quantile_boxes(std::vector<BoxSamples>{}, qs).empty());
}

TEST(QuantileBox, CopiesOfASampleAreAWeight) {
  std::mt19937_64 random(53);
  auto samples = scattered_samples(random, 6, 0.2, false);
  const std::vector<double> weights = {3, 1, 1, 0, 2, 1};
  std::vector<Box> copies;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (int k = 0; k < weights[i]; ++k) copies.push_back(samples[i]);
  }
  const Eigen::Vector4d coefficients = -copies[1].rotation.coeffs();
  copies[1].rotation.coeffs() = coefficients;
  const std::vector<double> qs = {0.0, 0.3, 0.6};
  const QuantileOptions corners_only{.points_per_box = 0};
  const auto weighted = quantile_boxes(BoxSamples{samples, weights}, qs, corners_only);
  const auto copied = quantile_boxes(copies, qs, corners_only);
  for (std::size_t i = 0; i < qs.size(); ++i) {
    EXPECT_TRUE(same_box(weighted[i].box, copied[i].box));
    EXPECT_EQ(weighted[i].fallback, copied[i].fallback);
  }
  EXPECT_EQ(occupancy_points({.boxes = copies}, corners_only).size(), 5 * 8u);
}

TEST(QuantileBox, FallsBackToTheMostOccupiedVolume) {
  const std::vector<Box> apart = {make_yaw_box({0, 0, 0}, {2, 2, 2}, 0),
                                  make_yaw_box({10, 0, 0}, {2, 2, 2}, 0)};
  const std::vector<double> qs = {0.4, 0.5, 0.9};
  const auto result = quantile_boxes(apart, qs);
  EXPECT_FALSE(result[0].fallback);
  EXPECT_TRUE(result[1].fallback);
  EXPECT_TRUE(equal_bytes(result[1].box, result[0].box));
  EXPECT_TRUE(equal_bytes(result[2].box, result[0].box));
  // Boxes that share a face: Q(0.5) is flat.
  const std::vector<Box> touching = {make_yaw_box({0, 0, 0}, {2, 2, 2}, 0),
                                     make_yaw_box({2, 0, 0}, {2, 2, 2}, 0)};
  const auto flat = quantile_boxes(touching, qs);
  EXPECT_TRUE(flat[1].fallback);
  EXPECT_NEAR(flat[1].box.size.x(), 4, 1e-12);
  // Without any usable point: the heaviest sample.
  const std::vector<double> weights = {1, 2};
  const auto none =
      quantile_boxes(BoxSamples{apart, weights}, qs, {.points_per_box = 0, .corners = false});
  for (const auto& q : none) {
    EXPECT_TRUE(q.fallback);
    EXPECT_TRUE(equal_bytes(q.box, apart[1]));
  }
}

TEST(QuantileBox, FarFromTheOriginNothingIsLost) {
  std::mt19937_64 random(59);
  auto near = nested_boxes(random, 6, false);
  for (Box& box : near) box.center -= near.back().center;
  auto far = near;
  for (Box& box : far) box.center += Vector3d(1e6, -1e6, 1e3);
  const std::vector<double> qs = {0.0, 0.4, 0.8};
  const auto here = quantile_boxes(near, qs);
  const auto there = quantile_boxes(far, qs);
  for (std::size_t i = 0; i < qs.size(); ++i) {
    EXPECT_LT((here[i].box.size - there[i].box.size).norm(), 1e-8);
    EXPECT_FALSE(there[i].fallback);
  }
}

TEST(QuantileBox, UncertaintyIsOneMinusTheOverlapOfCoreAndHull) {
  EXPECT_NEAR(quantile_uncertainty(make_yaw_box({0, 0, 0}, {4, 2, 2}, 0.3),
                                   make_yaw_box({0, 0, 0}, {4, 2, 1}, 0.3)),
              0.5, 1e-12);
  std::mt19937_64 random(67);
  double before = -1;
  for (const double spread : {0.0, 0.05, 0.2, 0.8}) {
    double mean = 0;
    for (int object = 0; object < 10; ++object) {
      const auto samples = scattered_samples(random, 32, spread, false);
      const auto boxes = quantile_boxes(samples, std::vector{0.2, 0.8});
      mean += quantile_uncertainty(boxes[0].box, boxes[1].box) / 10;
    }
    EXPECT_GT(mean, before) << spread;
    EXPECT_LE(mean, 1.0);
    before = spread > 0 ? mean : 1e-9;
  }
}

TEST(QuantileBox, GaussianUncertainty) {
  EXPECT_DOUBLE_EQ(gaussian_uncertainty(Vector3d(0.1, 0.2, 0.3), Vector3d(1, 2, 3)), 1e-3);
  const std::vector<Box> samples = {make_yaw_box({0, 0, 0}, {1, 1, 1}, 0),
                                    make_yaw_box({0, 0, 0}, {3, 3, 5}, 0)};
  EXPECT_DOUBLE_EQ(gaussian_uncertainty(BoxSamples{.boxes = samples}), 2.0 / 12.0);
  EXPECT_THROW(gaussian_uncertainty(Vector3d(-1, 1, 1), Vector3d(1, 1, 1)), InvalidArgument);
  EXPECT_THROW(gaussian_uncertainty(Vector3d(1, 1, 1), Vector3d(1, 0, 1)), InvalidArgument);
}

TEST(QuantileBox, BadInputIsRefusedByName) {
  using ::testing::HasSubstr;
  std::vector<Box> samples(3);
  const std::vector<double> qs = {0.5};
  const auto ask = [&](const BoxSamples& input, const std::vector<double>& quantiles,
                       const QuantileOptions& options = {}) {
    return refusal([&] { quantile_boxes(input, quantiles, options); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ask({}, qs), HasSubstr("at least one box sample"));
  for (const double bad : {-0.1, 1.1, nan}) {
    EXPECT_THAT(ask({.boxes = samples}, {0.1, bad}), HasSubstr("q in row 1"));
  }
  for (const std::vector<double>& weights :
       {std::vector{1.0}, {1.0, -1.0, 1.0}, {0.0, 0.0, 0.0}, {1.0, nan, 1.0}}) {
    EXPECT_THAT(ask({samples, weights}, qs), HasSubstr("weight"));
  }
  EXPECT_THAT(ask({.boxes = samples}, qs, {.points_per_box = -1}), HasSubstr("points_per_box"));
  EXPECT_THAT(ask({.boxes = samples}, qs, {.placement = "grid"}), HasSubstr("'grid'"));
  EXPECT_THAT(ask({.boxes = samples}, qs, {.points_per_box = 63, .placement = "jittered_grid"}),
              HasSubstr("cube"));
  samples[2].size.x() = nan;
  EXPECT_THAT(ask({.boxes = samples}, qs), HasSubstr("row 2"));
  const std::vector<Box> good(2);
  const std::vector<BoxSamples> batch = {{.boxes = good}, {.boxes = samples}};
  EXPECT_THAT(refusal([&] { quantile_boxes(batch, qs); }), HasSubstr("object 1"));
  EXPECT_THAT(refusal([&] { occupancy(good, {nan, 0, 0}); }), HasSubstr("finite"));
}

}  // namespace
