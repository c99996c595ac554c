#include "arbox/geometry/confidence_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "arbox/base/error.h"
#include "support/box_samples.h"

namespace {

using namespace arbox::geometry;
using namespace arbox::testing;
using arbox::InvalidArgument;

TEST(ConfidenceBox, OfOrderedSamplesLieWithinQuantileBoxes) {
  std::mt19937_64 random(61);
  const std::vector<double> ps = {0.9, 0.3, 1.0};
  const std::vector<double> qs = {0.1, 0.7, 0.0};
  for (int object = 0; object < 20; ++object) {
    const auto samples = nested_boxes(random, 10, false);
    const auto confidence = confidence_boxes({.boxes = samples}, ps);
    const auto quantile = quantile_boxes(samples, qs);
    for (std::size_t i = 0; i < ps.size(); ++i) {
      EXPECT_EQ(confidence[i].p, ps[i]);
      EXPECT_GE(held_share({.boxes = samples}, confidence[i].box), ps[i] - 1e-12);
      EXPECT_GT(held_share({.boxes = std::span(&confidence[i].box, 1)}, quantile[i].box, 1 - 1e-6),
                0.5);
    }
  }
}

TEST(ConfidenceBox, GrowsUntilTheVolumeOfTheLastSampleCounts) {
  std::vector<Box> samples;
  for (double scale = 1; scale <= 10; ++scale) {
    samples.push_back(make_yaw_box({8, 3, 0}, {2 * scale, scale, 1}, 0.4));
  }
  for (const ConfidenceBox& box :
       confidence_boxes({.boxes = samples}, std::vector{0.2, 0.5, 0.9, 1.0})) {
    const double last = volume(samples[std::lround(10 * box.p) - 1]);
    EXPECT_GT(volume(box.box), kHeldIog * last);
    EXPECT_LT(volume(box.box), (kHeldIog + 0.01) * last) << "256 degrees lie between two samples";
  }
}

TEST(ConfidenceBox, OfNearlyEqualSamplesIsTheirCore) {
  std::mt19937_64 random(64);
  const auto samples = scattered_samples(random, 64, 0.005, true);
  const auto quantile = quantile_boxes(samples, std::vector{63.0 / 64, 0.1});
  ASSERT_EQ(held_share({.boxes = samples}, quantile[0].box), 1.0);
  for (const ConfidenceBox& box : confidence_boxes({.boxes = samples}, std::vector{0.5, 0.9})) {
    EXPECT_TRUE(equal_bytes(box.box, quantile[0].box));
  }
  EXPECT_LT(volume(quantile[0].box), volume(quantile[1].box));
}

TEST(ConfidenceBox, HoldsItsShareOfSamplesWhoseFacesAreAllUnsure) {
  std::mt19937_64 random(62);
  double quantile_held = 0.0, over = 0.0;
  for (int object = 0; object < 20; ++object) {
    const auto samples = scattered_samples(random, 64, 0.3, true);
    const std::vector<double> ps = {0.95, 0.5, 0.8, 0.9};
    const auto boxes = confidence_boxes({.boxes = samples}, ps);
    for (const ConfidenceBox& box : boxes) {
      const double held = held_share({.boxes = samples}, box.box);
      EXPECT_GE(held, box.p - 1e-12) << object;
      over += (held - box.p) / 80;
    }
    EXPECT_LE(volume(boxes[1].box), volume(boxes[2].box) + 1e-9);
    const Box plain = quantile_boxes(samples, std::vector{0.5})[0].box;
    quantile_held += held_share({.boxes = samples}, plain) / 20;
    EXPECT_GE(volume(boxes[1].box), volume(plain) - 1e-9);
  }
  EXPECT_LT(quantile_held, 0.4) << "or the quantile box alone would do";
  EXPECT_LT(over, 0.015) << "a sample is a share of 0.016";
}

TEST(ConfidenceBox, HeldSharesCountWeightsAndVolume) {
  const std::vector<Box> samples = {make_yaw_box({0, 0, 0}, {4, 2, 2}, 0),
                                    make_yaw_box({0, 0, 0}, {4.1, 2, 2}, 0),
                                    make_yaw_box({0, 0, 0}, {8, 2, 2}, 0)};
  const Box box = samples[0];
  EXPECT_NEAR(held_share({.boxes = samples}, box), 2.0 / 3, 1e-12);
  EXPECT_NEAR(held_share({.boxes = samples}, box, 0.99), 1.0 / 3, 1e-12);
  const std::vector<double> weights = {1.0, 0.0, 3.0};
  EXPECT_NEAR(held_share({.boxes = samples, .weights = weights}, box), 0.25, 1e-12);
}

TEST(ConfidenceBox, OverlappingSharesCountWeightsAndIou) {
  const Box box = make_yaw_box({0, 0, 0}, {4, 2, 2}, 0);
  // IoU 1, 4 / 8 and 2 / 6.
  const std::vector<Box> samples = {box, make_yaw_box({0, 0, 0}, {8, 2, 2}, 0),
                                    make_yaw_box({2, 0, 0}, {4, 2, 2}, 0)};
  EXPECT_NEAR(overlapping_share({.boxes = samples}, box, 0.0), 1.0, 1e-12);
  EXPECT_NEAR(overlapping_share({.boxes = samples}, box, 0.4), 2.0 / 3, 1e-12);
  EXPECT_NEAR(overlapping_share({.boxes = samples}, box, 0.6), 1.0 / 3, 1e-12);
  const std::vector<double> weights = {1.0, 2.0, 5.0};
  EXPECT_NEAR(overlapping_share({.boxes = samples, .weights = weights}, box, 0.4), 3.0 / 8, 1e-12);
  EXPECT_EQ(overlapping_share({.boxes = samples}, make_yaw_box({90, 0, 0}, {1, 1, 1}, 0), 0.1), 0);
  EXPECT_THROW(overlapping_share(BoxSamples{}, box, 0.5), InvalidArgument);
}

TEST(ConfidenceBox, ManyObjectsAreThoseOneByOneAndBadInputIsRefused) {
  std::mt19937_64 random(63);
  const auto first = scattered_samples(random, 16, 0.3, false);
  const auto second = scattered_samples(random, 16, 0.3, true);
  const std::vector<BoxSamples> objects = {{.boxes = first, .object = 4},
                                           {.boxes = second, .object = 5}};
  const std::vector<double> ps = {0.5, 0.9};
  const auto together = confidence_boxes(objects, ps, {.threads = 2});
  ASSERT_EQ(together.size(), 2u);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto alone = confidence_boxes(objects[i], ps);
    for (std::size_t k = 0; k < ps.size(); ++k) {
      EXPECT_TRUE(equal_bytes(together[i][k].box, alone[k].box));
    }
  }
  EXPECT_EQ(confidence_boxes(objects, {}).front().size(), 0u);
  EXPECT_THROW(confidence_boxes({.boxes = first}, std::vector{1.1}), InvalidArgument);
  EXPECT_THROW(confidence_boxes({.boxes = first}, std::vector{std::nan("")}), InvalidArgument);
  EXPECT_THROW(confidence_boxes(BoxSamples{}, ps), InvalidArgument);
  EXPECT_THROW(held_share(BoxSamples{}, objects[0].boxes[0]), InvalidArgument);
}

}  // namespace
