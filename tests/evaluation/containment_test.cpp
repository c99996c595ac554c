#include "arbox/evaluation/containment.h"

#include <gtest/gtest.h>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"

namespace arbox::evaluation {
namespace {

using geometry::Box;
using geometry::make_yaw_box;
using geometry::QuantileBox;

Box cube(double x, double length = 1.0) { return make_yaw_box({x, 0, 0}, {length, 1, 1}, 0.0); }

Box random_box(std::uint64_t object) {
  const RandomStream stream(31, object, 0);
  return make_yaw_box({stream.uniform(0), stream.uniform(1), stream.uniform(2)},
                      {stream.uniform(3, 1, 2), stream.uniform(4, 1, 2), stream.uniform(5, 1, 2)},
                      stream.uniform(6, -3, 3));
}

TEST(MeanOverlap, ByHand) {
  // IoU 1 and 1/2, IoG 1 and 1: the second prediction is twice its true box.
  const std::vector<Box> predictions = {cube(0), cube(5, 2)};
  const std::vector<Box> truth = {cube(0), cube(5)};
  const auto mean = mean_overlap(predictions, truth);
  ASSERT_TRUE(mean);
  EXPECT_NEAR(mean->iou, 0.75, 1e-12);
  EXPECT_NEAR(mean->iog, 1.0, 1e-12);
  EXPECT_NEAR(mean_overlap(truth, predictions)->iog, 0.75, 1e-12);
}

TEST(MeanOverlap, AgreesWithAverageOverPairs) {
  std::vector<Box> first, second;
  double iou = 0.0, iog = 0.0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    first.push_back(random_box(2 * i));
    second.push_back(random_box(2 * i + 1));
    const double shared = geometry::overlap(first.back(), second.back(),
                                            {.measure = geometry::Overlap::kIntersection});
    const double one = first.back().size.prod(), other = second.back().size.prod();
    iou += shared / (one + other - shared) / 100.0;
    iog += shared / other / 100.0;
  }
  const auto mean = mean_overlap(first, second);
  EXPECT_NEAR(mean->iou, iou, 1e-9);
  EXPECT_NEAR(mean->iog, iog, 1e-9);
}

TEST(ContainedFraction, CountsPairsAboveTheLimit) {
  const std::vector<Box> truth = {cube(0), cube(0), cube(0), cube(0)};
  const std::vector<Box> predictions = {cube(0, 3), cube(0.04), cube(0.06), cube(9)};
  EXPECT_EQ(*contained_fraction(predictions, truth), 0.5);
  EXPECT_EQ(*contained_fraction(predictions, truth, 0.9), 0.75);
}

TEST(ContainmentCurve, ComparesPromiseAndFact) {
  const auto object = [](double narrow) {
    return std::vector<QuantileBox>{{.q = 0.8, .box = cube(0, narrow)}, {.q = 0.2, .box = cube(0)}};
  };
  const std::vector<std::vector<QuantileBox>> objects = {object(0.5), object(0.97)};
  const auto curve = containment_curve(objects, std::vector<Box>{cube(0), cube(0)});
  ASSERT_EQ(curve.size(), 2u);
  EXPECT_NEAR(curve[0].promised, 0.2, 1e-12);
  EXPECT_EQ(curve[0].contained, 0.5);
  EXPECT_EQ(curve[1].q, 0.2);
  EXPECT_EQ(curve[1].contained, 1.0);
}

TEST(Containment, NothingGivesNothing) {
  EXPECT_FALSE(mean_overlap({}, {}));
  EXPECT_FALSE(contained_fraction({}, {}));
  EXPECT_TRUE(containment_curve({}, {}).empty());
}

TEST(Containment, RefusesWhatDoesNotMatch) {
  const std::vector<Box> one = {cube(0)};
  EXPECT_THROW(mean_overlap(one, {}), InvalidArgument);
  EXPECT_THROW(contained_fraction(one, {}), InvalidArgument);
  EXPECT_THROW(mean_overlap(one, std::vector<Box>{cube(0, -1)}), InvalidArgument);
  const std::vector<std::vector<QuantileBox>> objects = {{{.q = 0.8, .box = cube(0)}},
                                                         {{.q = 0.7, .box = cube(0)}}};
  EXPECT_THROW(containment_curve(objects, one), InvalidArgument);
  EXPECT_THROW(containment_curve(objects, std::vector<Box>{cube(0), cube(0)}), InvalidArgument);
}

}  // namespace
}  // namespace arbox::evaluation
