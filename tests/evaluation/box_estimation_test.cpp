#include "arbox/evaluation/box_estimation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"
#include "io/expect_refusal.h"

namespace arbox {
namespace {

using evaluation::box_error;
using evaluation::evaluate_boxes;
using geometry::Box;

Box random_box(const RandomStream& random, std::uint32_t& draw) {
  const auto between = [&](double low, double high) { return random.uniform(draw++, low, high); };
  return {.center = {between(-0.2, 0.2), between(-0.2, 0.2), between(-0.2, 0.2)},
          .size = {between(0.2, 1), between(0.2, 1), between(0.2, 1)},
          .rotation = geometry::to_quaternion(
              geometry::ZyzAngles{between(0, 6.28), between(0, 3.14), between(0, 6.28)})};
}

/// IoU and IoG by counting points of a fine lattice in the truth's hull.
std::pair<double, double> counted(const Box& predicted, const Box& truth) {
  const auto hull =
      geometry::axis_aligned_hull(predicted).merged(geometry::axis_aligned_hull(truth));
  constexpr int kSteps = 60;
  double both = 0, either = 0, in_truth = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Array3d at((i % kSteps) + 0.5, (i / kSteps % kSteps) + 0.5,
                            (i / kSteps / kSteps) + 0.5);
    const Eigen::Vector3d point = hull.min().array() + at / kSteps * hull.sizes().array();
    const bool p = geometry::contains(predicted, point), t = geometry::contains(truth, point);
    both += p && t, either += p || t, in_truth += t;
  }
  return {both / either, both / in_truth};
}

/// Every renaming of axes and order of sizes, one by one.
std::pair<double, double> searched(const Box& predicted, const Box& truth) {
  double angle = 1e9, sizes = 1e9;
  for (const Box& same : geometry::equivalent_boxes(predicted)) {
    const double dot = std::abs(same.rotation.coeffs().dot(truth.rotation.coeffs()));
    angle = std::min(angle, 2 * std::acos(std::min(1.0, dot)));
  }
  std::array<int, 3> order = {0, 1, 2};
  do {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += std::abs(predicted.size[order[i]] - truth.size[i]);
    sizes = std::min(sizes, sum);
  } while (std::next_permutation(order.begin(), order.end()));
  return {angle, sizes};
}

TEST(BoxEstimation, AgreesWithBruteForce) {
  const RandomStream random(5, 0, 0);
  std::uint32_t draw = 0;
  for (int i = 0; i < 40; ++i) {
    const Box predicted = random_box(random, draw), truth = random_box(random, draw);
    const auto error = box_error(predicted, truth);
    const auto [iou, iog] = counted(predicted, truth);
    EXPECT_NEAR(error.iou, iou, 0.02);
    EXPECT_NEAR(error.iog, iog, 0.02);
    EXPECT_NEAR(error.f1, 2 * error.iou * error.iog / (error.iou + error.iog), 1e-12);
    const auto [angle, sizes] = searched(predicted, truth);
    EXPECT_NEAR(error.quaternion, angle, 1e-7);
    EXPECT_NEAR(error.dimensions, sizes, 1e-12);
    EXPECT_NEAR(error.center, (predicted.center - truth.center).norm(), 1e-15);
  }
}

TEST(BoxEstimation, RenamedBoxesHaveNoError) {
  const RandomStream random(6, 0, 0);
  std::uint32_t draw = 0;
  const Box truth = random_box(random, draw);
  for (const Box& same : geometry::equivalent_boxes(truth)) {
    const auto error = box_error(same, truth);
    EXPECT_NEAR(error.iou, 1.0, 1e-9);
    EXPECT_NEAR(error.dimensions + error.quaternion + error.center, 0.0, 1e-6);
  }
  const Box half = geometry::make_yaw_box(truth.center, truth.size, 3.14159265358979);
  const Box whole = geometry::make_yaw_box(truth.center, truth.size, 0.0);
  EXPECT_NEAR(box_error(half, whole, geometry::BoxSymmetry::kNone).quaternion, M_PI, 1e-6);
  EXPECT_NEAR(box_error(half, whole, geometry::BoxSymmetry::kHalfTurns).quaternion, 0.0, 1e-6);
}

TEST(BoxEstimation, ReportTellsBothF1) {
  const Box unit;
  Box twice = unit, far = unit;
  twice.size.x() = 2.0;
  far.center.x() = 5.0;
  const std::vector<Box> truth = {unit, unit}, predicted = {twice, far};
  const auto report = evaluate_boxes(predicted, truth);
  EXPECT_DOUBLE_EQ(report.mean.iou, 0.25);
  EXPECT_DOUBLE_EQ(report.mean.iog, 0.5);
  EXPECT_DOUBLE_EQ(report.f1_of_means, 2 * 0.25 * 0.5 / 0.75);
  EXPECT_DOUBLE_EQ(report.mean.f1, 0.5 * (2 * 0.5 / 1.5));
  EXPECT_DOUBLE_EQ(report.mean.dimensions, 0.5);
  EXPECT_DOUBLE_EQ(report.mean.center, 2.5);
  EXPECT_DOUBLE_EQ(report.contained, 0.5);
  const auto json = nlohmann::json::parse(evaluation::to_json(report));
  EXPECT_EQ(json.at("mean_f1"), report.mean.f1);
  EXPECT_NE(evaluation::to_table(report).find("F1 of means  0.3333"), std::string::npos);
  EXPECT_EQ(evaluate_boxes({}, {}).objects, 0u);
  testing::expect_refusal([&] { evaluate_boxes(predicted, {}); }, {"one prediction", "got 2"});
  std::vector<Box> bad = predicted;
  bad[1].size.x() = -1;
  testing::expect_refusal([&] { evaluate_boxes(bad, truth); }, {"predictions", "1"});
}

TEST(BoxEstimation, ThreadsChangeNothing) {
  const RandomStream random(7, 0, 0);
  std::uint32_t draw = 0;
  std::vector<Box> predicted, truth;
  for (int i = 0; i < 1000; ++i) {
    predicted.push_back(random_box(random, draw));
    truth.push_back(random_box(random, draw));
  }
  const auto one = evaluate_boxes(predicted, truth, {.threads = 1});
  const auto two = evaluate_boxes(predicted, truth, {.threads = 3});
  EXPECT_EQ(evaluation::to_json(one), evaluation::to_json(two));
}

}  // namespace
}  // namespace arbox
