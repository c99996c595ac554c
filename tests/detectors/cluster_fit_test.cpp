#include "arbox/detectors/cluster_fit/cluster_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"
#include "detectors/birds_eye_iou.h"
#include "support/street_scene.h"

namespace arbox::detectors {
namespace {

using geometry::Box;
using geometry::Detection;

const Detection* best_match(const std::vector<Detection>& detections, const Detection& truth) {
  const Detection* best = nullptr;
  double most = 0.0;
  for (const Detection& detection : detections) {
    const double iou = birds_eye_iou(detection.box, truth.box);
    if (detection.label == truth.label && iou > most) {
      best = &detection;
      most = iou;
    }
  }
  return best;
}

/// One car on flat ground without noise.
arbox::testing::StreetScene one_car(double x, double y, double yaw) {
  const double floor = -1.73;
  std::vector<Detection> truth(1);
  truth[0].label = "Car";
  truth[0].box = geometry::make_yaw_box({x, y, floor + 0.76}, {3.9, 1.65, 1.52}, yaw);
  std::vector<arbox::testing::OwnedConvex> solids;
  for (const auto& solid : arbox::testing::car_solids(truth[0].box)) solids.push_back({solid, 0});
  return arbox::testing::scan(solids, truth, [=](double, double) { return floor; },
                              {.azimuth_step = 0.17, .noise = 0.5});
}

std::vector<Detection> detections_of(const arbox::testing::StreetScene& scene,
                                     const DetectionRequest& request = {}) {
  return ClusterFit().detect(scene.cloud.view(), request).detections;
}

TEST(ClusterFit, FindsTheCarsOfAStreet) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const double slope : {0.0, 0.03, -0.03}) {
      const auto scene =
          arbox::testing::make_street({.seed = seed, .slope_x = slope, .azimuth_step = 0.17});
      const auto found = detections_of(scene, {.score = 0.3});
      int cars = 0, matched = 0;
      for (std::size_t i = 0; i < scene.truth.size(); ++i) {
        if (scene.truth[i].label != "Car" || scene.returns[i] < 200) continue;
        ++cars;
        const Detection* match = best_match(found, scene.truth[i]);
        if (match != nullptr && birds_eye_iou(match->box, scene.truth[i].box) > 0.5) ++matched;
      }
      EXPECT_GE(cars, 12);
      EXPECT_GE(matched, 0.75 * cars)
          << "seed " << seed << ", slope " << slope << ": " << matched << " of " << cars;
    }
  }
}

TEST(ClusterFit, BoxesStandOnTheGroundWithTheRightHeight) {
  const auto scene = arbox::testing::make_street({.slope_x = 0.04, .slope_y = -0.03});
  const auto found = detections_of(scene, {.score = 0.5});
  int checked = 0;
  for (std::size_t i = 0; i < scene.truth.size(); ++i) {
    const Detection* match = best_match(found, scene.truth[i]);
    if (match == nullptr || scene.returns[i] < 200) continue;
    const auto bottom = [](const Box& box) { return box.center.z() - 0.5 * box.size.z(); };
    EXPECT_NEAR(bottom(match->box), bottom(scene.truth[i].box), 0.15) << scene.truth[i].label;
    EXPECT_NEAR(match->box.size.z(), scene.truth[i].box.size.z(), 0.25) << scene.truth[i].label;
    ++checked;
  }
  EXPECT_GE(checked, 8);
}

TEST(ClusterFit, FitsACarAtAnyHeading) {
  for (double yaw = -3.1; yaw < 3.1; yaw += 0.21) {
    const auto scene = one_car(9.0, 3.0, yaw);
    const auto found = detections_of(scene, {.score = 0.3});
    const Detection* match = best_match(found, scene.truth[0]);
    ASSERT_NE(match, nullptr) << "yaw " << yaw;
    EXPECT_GT(birds_eye_iou(match->box, scene.truth[0].box), 0.7) << "yaw " << yaw;
    EXPECT_LT(std::abs(std::remainder(geometry::yaw(match->box) - yaw, std::numbers::pi)), 0.12)
        << "yaw " << yaw;
  }
}

// What is seen over the roof of the car before it is as wide as deep: only the slope of its rear
// window tells which way it stands.
TEST(ClusterFit, KnowsTheRearOfACarBehindAnother) {
  const auto scene = arbox::testing::make_street({.azimuth_step = 0.17});
  const auto is_it = [](const Detection& one) {
    return (one.box.center.head<2>() - Eigen::Vector2d(18.0, -4.3)).norm() < 1.5;
  };
  const auto truth = std::find_if(scene.truth.begin(), scene.truth.end(), is_it);
  const auto found = detections_of(scene, {.score = 0.3});
  const auto car = std::find_if(found.begin(), found.end(), is_it);
  ASSERT_TRUE(truth != scene.truth.end() && car != found.end());
  EXPECT_EQ(car->label, "Car");
  const double turn = geometry::yaw(car->box) - geometry::yaw(truth->box);
  EXPECT_LT(std::abs(std::remainder(turn, std::numbers::pi)), 0.25);
}

// The scanner sees the rear and some of the roof; the front must be guessed from the class.
TEST(ClusterFit, CompletesTheSideThatTheSensorDoesNotSee) {
  const auto scene = one_car(20.0, 0.0, 0.0);
  const auto found = detections_of(scene, {.quantiles = {0.2, 0.8}, .samples = true});
  ASSERT_FALSE(found.empty());
  const Detection& car = found.front();
  EXPECT_EQ(car.label, "Car");
  EXPECT_NEAR(car.box.size.x(), 3.9, 0.35);
  EXPECT_NEAR(car.box.size.y(), 1.65, 0.15);
  EXPECT_NEAR(car.box.center.x() - 0.5 * car.box.size.x(), 20.0 - 0.5 * 3.9, 0.2);
}

struct Spread {
  double near_end, far_end, side;
};

/// Deviations of the samples' ends along x and of their sides, for a car that looks along x.
Spread spread_of(const std::vector<Box>& samples) {
  const auto deviation = [&](auto value) {
    double sum = 0.0, squares = 0.0;
    for (const Box& box : samples) {
      sum += value(box);
      squares += value(box) * value(box);
    }
    const auto count = static_cast<double>(samples.size());
    return std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)));
  };
  return {deviation([](const Box& b) { return b.center.x() - 0.5 * b.size.x(); }),
          deviation([](const Box& b) { return b.center.x() + 0.5 * b.size.x(); }),
          deviation([](const Box& b) { return b.center.y() - 0.5 * b.size.y(); })};
}

TEST(ClusterFit, SamplesSpreadWhereNothingWasSeen) {
  const auto found = detections_of(one_car(20.0, 0.0, 0.0), {.samples = true});
  ASSERT_FALSE(found.empty());
  ASSERT_EQ(found[0].samples.size(), 64u);
  const Spread spread = spread_of(found[0].samples);
  EXPECT_GT(spread.far_end, 0.15);
  EXPECT_GT(spread.far_end, 2.0 * spread.near_end);
  EXPECT_GT(spread.far_end, 2.0 * spread.side);
}

TEST(ClusterFit, IsLessSureOfWhatItSeesLess) {
  const DetectionRequest request{.quantiles = {0.5}};
  const auto from_the_side = detections_of(one_car(5.0, 6.0, 0.0), request);
  const auto from_behind = detections_of(one_car(20.0, 0.0, 0.0), request);
  ASSERT_FALSE(from_the_side.empty());
  ASSERT_FALSE(from_behind.empty());
  EXPECT_LT(*from_the_side[0].uncertainty, *from_behind[0].uncertainty);
}

TEST(ClusterFit, AnswersWhatIsAskedForAndNothingElse) {
  const auto scene = one_car(8.0, 4.0, 0.4);
  const Detection plain = detections_of(scene).at(0);
  EXPECT_TRUE(plain.quantile_boxes.empty() && plain.confidence_boxes.empty());
  EXPECT_TRUE(plain.samples.empty() && !plain.uncertainty && !plain.log_density);
  const Detection full =
      detections_of(scene, {.quantiles = {0.8, 0.1}, .confidences = {0.5, 0.9}}).at(0);
  EXPECT_EQ(full.score, plain.score);
  EXPECT_EQ(full.box.center, plain.box.center);
  ASSERT_EQ(full.quantile_boxes.size(), 2u);
  EXPECT_EQ(full.quantile_boxes[0].q, 0.8);
  EXPECT_LT(volume(full.quantile_boxes[0].box), volume(full.quantile_boxes[1].box));
  ASSERT_EQ(full.confidence_boxes.size(), 2u);
  EXPECT_EQ(full.confidence_boxes[1].p, 0.9);
  EXPECT_LT(volume(full.confidence_boxes[0].box), volume(full.confidence_boxes[1].box));
  EXPECT_TRUE(full.samples.empty());
  ASSERT_TRUE(full.uncertainty.has_value());
  EXPECT_GT(*full.uncertainty, 0.0);
  EXPECT_LT(*full.uncertainty, 1.0);
}

bool equal(const Box& one, const Box& other) {
  return one.center == other.center && one.size == other.size &&
         one.rotation.coeffs() == other.rotation.coeffs();
}

TEST(ClusterFit, GivesTheSameBytesAtAnyThreadCount) {
  const auto scene = arbox::testing::make_street();
  DetectionRequest request{.quantiles = {0.3}, .samples = true};
  request.threads = 1;
  const auto one = detections_of(scene, request);
  request.threads = 3;
  const auto three = detections_of(scene, request);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].score, three[i].score);
    ASSERT_TRUE(equal(one[i].box, three[i].box));
    ASSERT_TRUE(equal(one[i].quantile_boxes[0].box, three[i].quantile_boxes[0].box));
    for (std::size_t k = 0; k < one[i].samples.size(); ++k) {
      ASSERT_TRUE(equal(one[i].samples[k], three[i].samples[k]));
    }
  }
}

TEST(ClusterFit, ASeedChangesTheSamplesAndNotTheBoxes) {
  const auto scene = one_car(8.0, 4.0, 0.4);
  const Detection one = detections_of(scene, {.samples = true, .seed = 1}).at(0);
  const Detection two = detections_of(scene, {.samples = true, .seed = 2}).at(0);
  EXPECT_TRUE(equal(one.box, two.box));
  EXPECT_FALSE(equal(one.samples[0], two.samples[0]));
}

TEST(ClusterFit, ScoresFallAndAreCutAtTheOneAskedFor) {
  const auto scene = arbox::testing::make_street();
  const auto all = detections_of(scene);
  const auto some = detections_of(scene, {.score = 0.4});
  ASSERT_GT(all.size(), some.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_GE(all[i].score, 0.0);
    EXPECT_LE(all[i].score, 1.0);
    if (i > 0) {
      EXPECT_LE(all[i].score, all[i - 1].score);
    }
    if (i < some.size()) {
      EXPECT_TRUE(equal(all[i].box, some[i].box));
      EXPECT_GE(some[i].score, 0.4);
    }
  }
}

TEST(ClusterFit, BoxesThatItGivesAreValidAndApart) {
  const auto found = detections_of(arbox::testing::make_street());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NO_THROW(require_valid(found[i].box, "test"));
    const double yaw = geometry::yaw(found[i].box);
    EXPECT_TRUE(yaw > -0.5 * std::numbers::pi - 1e-9 && yaw <= 0.5 * std::numbers::pi + 1e-9);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_LE(birds_eye_iou(found[i].box, found[k].box), 0.1 + 1e-9);
    }
  }
}

TEST(ClusterFit, FindsNothingWhereNothingIs) {
  const ClusterFit detector;
  EXPECT_TRUE(detector.detect({}).detections.empty());

  const std::vector<float> one = {5.0f, 1.0f, -1.7f};
  EXPECT_TRUE(detector.detect(geometry::PointCloudView::packed(one.data(), 1)).detections.empty());

  std::vector<float> same;
  for (int i = 0; i < 3000; ++i) same.insert(same.end(), {7.0f, -2.0f, -1.0f});
  EXPECT_TRUE(
      detector.detect(geometry::PointCloudView::packed(same.data(), 1000)).detections.empty());

  const auto ground =
      arbox::testing::scan({}, {}, [](double x, double) { return -1.7 + 0.02 * x; }, {});
  EXPECT_GT(ground.cloud.size(), 10000u);
  EXPECT_TRUE(detections_of(ground, {.score = 0.05}).empty());
}

TEST(ClusterFit, CountsPointsThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> bad = {nan, nan, nan, 1.0f, nan, 0.0f, INFINITY, 0.0f, 0.0f};
  const auto result = ClusterFit().detect(geometry::PointCloudView::packed(bad.data(), 3));
  EXPECT_TRUE(result.detections.empty());
  EXPECT_EQ(result.dropped_points, 3);

  auto scene = one_car(9.0, 2.0, 0.3);
  const auto before = detections_of(scene, {.score = 0.3});
  scene.cloud.values.insert(scene.cloud.values.end(), {nan, 0, 0, 0, 0, 0, -INFINITY, 0});
  const auto after = ClusterFit().detect(scene.cloud.view(), {.score = 0.3});
  EXPECT_EQ(after.dropped_points, 2);
  ASSERT_EQ(after.detections.size(), before.size());
  EXPECT_TRUE(equal(after.detections[0].box, before[0].box));
}

TEST(ClusterFit, PassesOverPointsThatAreAbsurdlyFar) {
  auto scene = one_car(9.0, 2.0, 0.3);
  const auto before = detections_of(scene, {.score = 0.3});
  scene.cloud.values.insert(scene.cloud.values.end(),
                            {1e30f, 0, 0, 0, -3e38f, 3e38f, 3e38f, 0, 0, 0, 1e9f, 0});
  const auto after = detections_of(scene, {.score = 0.3});
  ASSERT_EQ(after.size(), before.size());
  EXPECT_TRUE(equal(after[0].box, before[0].box));
}

TEST(ClusterFit, NeedsCoordinatesOnlyWhateverTheirLayout) {
  const auto scene = one_car(9.0, 2.0, 0.3);
  const auto packed = detections_of(scene);
  // 32 bytes a point, coordinates at byte 8, no other channel.
  std::vector<float> padded;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    const Eigen::Vector3f p = scene.cloud.view().position(i);
    padded.insert(padded.end(), {-1.0f, -1.0f, p.x(), p.y(), p.z(), -1.0f, -1.0f, -1.0f});
  }
  const geometry::PointCloudView view(padded.data(), scene.cloud.size(), 32, 8);
  const auto found = ClusterFit().detect(view).detections;
  ASSERT_EQ(found.size(), packed.size());
  EXPECT_TRUE(equal(found[0].box, packed[0].box));
}

TEST(ClusterFit, HoldsTenMillionPoints) {
  const auto scene = one_car(9.0, 2.0, 0.3);
  const RandomStream draw(1, 0, 0);
  const std::size_t copies = 10'000'000 / scene.cloud.size() + 1;
  std::vector<float> values;
  values.reserve(3 * copies * scene.cloud.size());
  for (std::size_t copy = 0; copy < copies; ++copy) {
    const auto lift =
        static_cast<float>(draw.uniform(static_cast<std::uint32_t>(copy), -0.01, 0.01));
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
      const Eigen::Vector3f p = scene.cloud.view().position(i);
      values.insert(values.end(), {p.x() + lift, p.y() - lift, p.z() + lift});
    }
  }
  ASSERT_GE(values.size() / 3, 10'000'000u);
  const auto view = geometry::PointCloudView::packed(values.data(), values.size() / 3);
  const auto found = ClusterFit().detect(view, {.score = 0.3}).detections;
  ASSERT_FALSE(found.empty());
  EXPECT_GT(birds_eye_iou(found[0].box, scene.truth[0].box), 0.6);
}

TEST(ClusterFit, RefusesOptionsAndRequestsOutOfRange) {
  EXPECT_THROW(ClusterFit({.max_range = -1.0}), ConfigError);
  EXPECT_THROW(ClusterFit({.tolerance = std::nan("")}), ConfigError);
  EXPECT_THROW(ClusterFit({.ground = {.thickness = 0.0}}), ConfigError);
  EXPECT_THROW(ClusterFit({.sample_count = 0}), ConfigError);
  const ClusterFit detector;
  for (const double bad : {0.0, 1.0, -0.5, 7.0, std::nan("")}) {
    EXPECT_THROW(detector.detect({}, {.quantiles = {bad}}), InvalidArgument);
    EXPECT_THROW(detector.detect({}, {.confidences = {bad}}), InvalidArgument);
  }
  EXPECT_THROW(detector.detect({}, {.score = 1.5}), InvalidArgument);
  EXPECT_THROW(detector.detect({}, {.score = std::nan("")}), InvalidArgument);
}

}  // namespace
}  // namespace arbox::detectors
