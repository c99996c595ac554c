#include "arbox/heads/distribution_boxes.h"

#include <ATen/ops/arange.h>
#include <gtest/gtest.h>

#include <cmath>

#include "arbox/base/error.h"
#include "arbox/geometry/confidence_box.h"
#include "heads/listed_distribution.h"

namespace {

using namespace arbox;
using namespace arbox::heads;
using arbox::testing::ListedBox;
using arbox::testing::ListedDistribution;
using geometry::make_yaw_box;

/// The paper's stack: boxes on a floor of heights 1 to 4 / 4, equally likely.
std::vector<ListedBox> stack() {
  std::vector<ListedBox> boxes;
  for (int i = 1; i <= 4; ++i) {
    boxes.push_back({make_yaw_box({0, 0, i / 8.0}, {1, 1, i / 4.0}, 0.3), 0.25});
  }
  return boxes;
}

Streams streams(std::int64_t objects) { return {5, at::arange(objects, at::kLong)}; }

TEST(DistributionBoxes, GivesQuantileAndConfidenceBoxesAndUncertainty) {
  const ListedDistribution distribution({stack()});
  const auto result =
      distribution_boxes(distribution, streams(1),
                         {.samples = 400, .quantiles = {0.0, 0.6}, .confidences = {1.0, 0.4}});
  const ObjectBoxes& object = result.objects.at(0);
  EXPECT_EQ(object.samples.size(), 400u);
  ASSERT_EQ(object.quantile_boxes.size(), 2u);
  EXPECT_NEAR(object.quantile_boxes[0].box.size.z(), 1.0, 1e-9);
  // O > 0.6 holds below the height that three boxes in four reach.
  EXPECT_NEAR(object.quantile_boxes[1].box.size.z(), 0.5, 1e-9);
  EXPECT_EQ(object.quantile_boxes[1].q, 0.6);
  ASSERT_EQ(object.confidence_boxes.size(), 2u);
  EXPECT_EQ(object.confidence_boxes[0].p, 1.0);
  // They hold nearly all of the volume of the last box that counts.
  EXPECT_NEAR(object.confidence_boxes[0].box.size.z(), 1.0 * geometry::kHeldIog, 1e-3);
  EXPECT_NEAR(object.confidence_boxes[1].box.size.z(), 0.5 * geometry::kHeldIog, 1e-3);
  // O > 0.2 up to 1, O > 0.8 up to 0.25: IoU 0.25.
  EXPECT_NEAR(object.uncertainty.value(), 0.75, 1e-9);
  EXPECT_EQ(result.dropped, 0);
  EXPECT_FALSE(result.single_box);
}

TEST(DistributionBoxes, DropsWhatIsNotFiniteAndCountsIt) {
  auto broken = stack();
  broken[0].box.center.x() = std::nan("");
  broken[1].box.size.z() = 0.0;
  std::vector<ListedBox> lost{{broken[0].box, 1.0}};
  const ListedDistribution distribution({broken, lost, stack()});
  const auto result = distribution_boxes(distribution, streams(3), {.quantiles = {0.0}});
  EXPECT_GT(result.objects[0].dropped, 0);
  EXPECT_EQ(result.objects[0].dropped + std::ssize(result.objects[0].samples), 64);
  EXPECT_EQ(result.objects[0].quantile_boxes.size(), 1u);
  EXPECT_EQ(result.objects[1].dropped, 64);
  EXPECT_TRUE(result.objects[1].quantile_boxes.empty());
  EXPECT_FALSE(result.objects[1].uncertainty.has_value());
  EXPECT_EQ(result.objects[2].dropped, 0);
  EXPECT_EQ(result.dropped, result.objects[0].dropped + 64);
}

TEST(DistributionBoxes, AHeadWithoutDistributionSaysSo) {
  const geometry::Box box = make_yaw_box({3, 2, 1}, {4, 2, 1.5}, 0.7);
  const ListedDistribution distribution({{{box, 1.0}}}, Measure::kNone);
  const auto result = distribution_boxes(distribution, streams(1), {.quantiles = {0.0, 0.9}});
  EXPECT_TRUE(result.single_box);
  EXPECT_NEAR(result.objects[0].uncertainty.value(), 0.0, 1e-9);
  for (const auto& quantile : result.objects[0].quantile_boxes) {
    EXPECT_LT((quantile.box.size - box.size).norm(), 1e-9);
    EXPECT_LT((quantile.box.center - box.center).norm(), 1e-9);
  }
}

TEST(DistributionBoxes, AnObjectDoesNotDependOnTheBatch) {
  const ListedDistribution together({stack(), stack(), stack()}), alone({stack()});
  const auto batch = distribution_boxes(together, streams(3), {.quantiles = {0.4}});
  const auto one =
      distribution_boxes(alone, {5, at::arange(2, 3, at::kLong)}, {.quantiles = {0.4}});
  EXPECT_EQ(batch.objects[2].quantile_boxes[0].box.size, one.objects[0].quantile_boxes[0].box.size);
  EXPECT_EQ(batch.objects[2].uncertainty, one.objects[0].uncertainty);
}

TEST(DistributionBoxes, NothingGivesNothingAndBadOptionsAreRefused) {
  EXPECT_TRUE(distribution_boxes(ListedDistribution({}), streams(0)).objects.empty());
  const ListedDistribution distribution({stack()});
  EXPECT_THROW(distribution_boxes(distribution, streams(1), {.samples = 0}), ConfigError);
  EXPECT_THROW(distribution_boxes(distribution, streams(1), {.quantiles = {1.5}}), Error);
}

}  // namespace
