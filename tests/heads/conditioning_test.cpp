#include "arbox/heads/conditioning.h"

#include <ATen/ops/arange.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "arbox/base/error.h"
#include "heads/listed_distribution.h"

namespace {

using namespace arbox;
using namespace arbox::heads;
using arbox::testing::ListedBox;
using arbox::testing::ListedDistribution;
using geometry::make_yaw_box;

constexpr double kQuarter = std::numbers::pi / 2;

/// Two vectors of one solid (first and second), another box of that size, two of another size.
std::vector<ListedBox> parcel() {
  return {{make_yaw_box({5, 0, 1}, {1, 2, 3}, 0.0), 0.10},
          {make_yaw_box({5, 0, 1}, {2, 1, 3}, kQuarter), 0.06},
          {make_yaw_box({5, 0, 1}, {1, 2, 3}, 0.5), 0.12},
          {make_yaw_box({6, 0, 1}, {1, 1, 4}, 0.0), 0.30},
          {make_yaw_box({7, 0, 1}, {1, 1, 4}, 0.0), 0.42}};
}

const std::vector<KnownSize> kTwo{{"flat", {3, 1, 2}}, {"tall", {1, 4, 1}}};

TEST(Conditioning, MergesBeamsOfOneBoxBeforeSizesAreCompared) {
  const ListedDistribution distribution({parcel()});
  const auto result = given_known_sizes(distribution, kTwo);
  ASSERT_EQ(result.size(), 1u);
  // Six orders of 1 2 3 and three of 1 1 4. p(b | 1 2 3) = 10/22 and p(b | 2 1 3) = 1 are one box.
  const double flat = (10.0 / 22.0 + 1.0) / 6.0, tall = (42.0 / 72.0) / 3.0;
  EXPECT_EQ(result[0].known_size, 0u);
  EXPECT_NEAR(result[0].log_density, std::log(flat), 1e-9);
  EXPECT_NEAR(result[0].margin, std::log(flat / tall), 1e-9);
  EXPECT_NEAR(result[0].by_size[1].log_density, std::log(tall), 1e-9);
  EXPECT_EQ(result[0].by_size[1].box.center.x(), 7.0);
  EXPECT_EQ(result[0].box.center.x(), 5.0);
}

TEST(Conditioning, JointScoreAsksHowLikelyTheSizeIs) {
  const ListedDistribution distribution({parcel()});
  const auto result = given_known_sizes(distribution, kTwo, {.score = "joint"});
  EXPECT_EQ(result[0].known_size, 1u);
  EXPECT_NEAR(result[0].log_density, std::log(0.42), 1e-9);
  EXPECT_NEAR(result[0].margin, std::log(0.42 / 0.16), 1e-9);
  EXPECT_EQ(geometry::yaw(result[0].by_size[0].box), 0.0);
}

TEST(Conditioning, WithoutMergingEveryVectorStandsAlone) {
  auto boxes = parcel();
  boxes[1].box = make_yaw_box({5, 0, 1}, {2, 1, 3}, kQuarter + 1e-3);
  const ListedDistribution distribution({boxes});
  const auto strict = given_known_sizes(distribution, kTwo, {.score = "joint", .same_box = 0.0});
  EXPECT_NEAR(strict[0].by_size[0].log_density, std::log(0.12), 1e-9);
  const auto merged = given_known_sizes(distribution, kTwo, {.score = "joint"});
  EXPECT_NEAR(merged[0].by_size[0].log_density, std::log(0.16), 1e-9);
}

TEST(Conditioning, EveryObjectIsItsOwn) {
  const std::vector<ListedBox> other{{make_yaw_box({1, 1, 1}, {4, 1, 1}, 0.2), 1.0}};
  const ListedDistribution distribution({parcel(), other, parcel()});
  const auto result = given_known_sizes(distribution, kTwo);
  EXPECT_EQ(result[0].known_size, 0u);
  EXPECT_EQ(result[1].known_size, 1u);
  EXPECT_EQ(result[1].by_size[0].log_density, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(result[1].margin, std::numeric_limits<double>::infinity());
  EXPECT_EQ(result[2].log_density, result[0].log_density);
}

TEST(Conditioning, OneSizeHasAnInfiniteMarginAndEqualSizesNone) {
  const ListedDistribution distribution({parcel()});
  const auto one = given_known_sizes(distribution, std::vector<KnownSize>{{"a", {1, 2, 3}}});
  EXPECT_EQ(one[0].margin, std::numeric_limits<double>::infinity());
  const auto twins =
      given_known_sizes(distribution, std::vector<KnownSize>{{"a", {1, 2, 3}}, {"b", {2, 3, 1}}});
  EXPECT_EQ(twins[0].known_size, 0u);
  EXPECT_EQ(twins[0].margin, 0.0);
}

TEST(Conditioning, RefusesWhatIsNoSize) {
  const ListedDistribution distribution({parcel()});
  const auto with = [&](const Eigen::Vector3d& extents) {
    return given_known_sizes(distribution, std::vector<KnownSize>{{"crate", extents}});
  };
  EXPECT_THROW(given_known_sizes(distribution, {}), InvalidArgument);
  EXPECT_THROW(with({1, 0, 1}), InvalidArgument);
  EXPECT_THROW(with({1, -2, 1}), InvalidArgument);
  EXPECT_THROW(with({1, std::nan(""), 1}), InvalidArgument);
  EXPECT_THROW(given_known_sizes(distribution, kTwo, {.beam_width = 0}), ConfigError);
  EXPECT_THROW(given_known_sizes(distribution, kTwo, {.score = "best"}), ConfigError);
  EXPECT_TRUE(given_known_sizes(ListedDistribution({}), kTwo).empty());
}

TEST(CommonSize, IsTheLikeliestOverAllObjects) {
  const std::vector<ListedBox> other{{make_yaw_box({1, 1, 1}, {3, 2, 1}, 0.2), 0.9},
                                     {make_yaw_box({1, 1, 1}, {4, 1, 1}, 0.2), 0.1}};
  const ListedDistribution distribution({parcel(), other});
  const std::vector<Eigen::Vector3d> candidates{{1, 1, 4}, {1, 2, 3}, {3, 2, 1}};
  const CommonSize common = common_size(distribution, candidates);
  EXPECT_EQ(common.candidate, 1u);
  EXPECT_NEAR(common.log_densities[0], std::log(0.72 * 0.1), 1e-9);
  EXPECT_NEAR(common.log_densities[1], std::log(0.28 * 0.9), 1e-9);
  EXPECT_NEAR(common.margin, std::log(0.28 * 0.9 / (0.72 * 0.1)), 1e-9);  // 3 2 1 is no rival
  EXPECT_THROW(common_size(distribution, {}), InvalidArgument);
  EXPECT_THROW(common_size(distribution, std::vector<Eigen::Vector3d>{{1, 0, 1}}), InvalidArgument);
}

TEST(CommonSize, CandidatesComeFromTheObjects) {
  const ListedDistribution distribution({parcel(), parcel()});
  const auto sizes = draw_sizes(distribution, 100, {3, at::arange(2, at::kLong)});
  ASSERT_EQ(sizes.size(), 200u);
  int tall = 0;
  for (const Eigen::Vector3d& size : sizes) tall += size.z() == 4.0;
  EXPECT_NEAR(tall, 144, 5 * std::sqrt(200 * 0.72 * 0.28));
}

}  // namespace
