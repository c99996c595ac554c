#include "arbox/evaluation/uncertainty_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/evaluation/ranking.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/overlap.h"

namespace arbox::evaluation {
namespace {

using geometry::Detection;

constexpr double kTiny = 1e-12;

Detection car_at(double x, double length = 4.0) {
  Detection detection;
  detection.label = "Car";
  detection.score = 0.9;
  detection.box = geometry::make_yaw_box({x, 0, 0}, {length, 2, 1.5}, 0);
  return detection;
}

/// Moved along x so that the IoU is 2 / 6: the box is wrong only from a limit of 1 / 3.
UncertaintyScan half_a_length_off() { return {.detections = {car_at(2)}, .objects = {car_at(0)}}; }

TEST(Uncertainty, FiguresOfAHandMadeScan) {
  UncertaintyScan scan{.detections = {car_at(0), car_at(22), car_at(100)},
                       .objects = {car_at(0), car_at(20), car_at(50)}};
  scan.detections[0].quantile_boxes = {{.q = 0.1, .box = car_at(0, 5).box},
                                       {.q = 0.5, .box = car_at(0, 4).box}};
  scan.detections[1].quantile_boxes = {{.q = 0.1, .box = car_at(20, 8).box},
                                       {.q = 0.5, .box = car_at(22, 4).box}};
  scan.detections[0].confidence_boxes = {{.p = 0.9, .box = car_at(0, 5).box}};
  scan.detections[0].uncertainty = 0.1;
  scan.detections[1].uncertainty = 0.8;
  const auto report = evaluate_uncertainty(std::vector{scan}, {.wrong_iou = 0.5});
  EXPECT_EQ(report.scans, 1u);
  ASSERT_EQ(report.classes.size(), 1u);
  for (const UncertaintyFigures& figures : {report.classes[0], report.all}) {
    EXPECT_EQ(figures.objects, 3u);
    EXPECT_EQ(figures.found.boxes, 2u);
    EXPECT_EQ(figures.found.wrong, 1u);
    EXPECT_NEAR(figures.found.mean_iou, (1.0 + 1.0 / 3) / 2, kTiny);
    EXPECT_NEAR(figures.mean_iog, (1.0 + 0.5) / 2, kTiny);
    EXPECT_NEAR(figures.mean_f1, (1.0 + 0.4) / 2, kTiny);
    EXPECT_NEAR(figures.f1_of_means, 2 * (2.0 / 3) * 0.75 / (2.0 / 3 + 0.75), kTiny);
    ASSERT_EQ(figures.quantile_boxes.size(), 2u);
    EXPECT_EQ(figures.quantile_boxes[0].level, 0.1);
    EXPECT_NEAR(figures.quantile_boxes[0].promised, 0.9, kTiny);
    EXPECT_EQ(figures.quantile_boxes[0].contained, 1.0);
    EXPECT_EQ(figures.quantile_boxes[1].contained, 0.5);
    ASSERT_EQ(figures.confidence_boxes.size(), 1u);
    EXPECT_EQ(figures.confidence_boxes[0].boxes, 1u);
    EXPECT_EQ(figures.confidence_boxes[0].promised, 0.9);
    EXPECT_EQ(figures.found.roc_auc, 1.0);
    ASSERT_TRUE(figures.found.spearman);
    EXPECT_NEAR(*figures.found.spearman, -1.0, kTiny);
  }
  ASSERT_EQ(report.found.size(), 2u);
  EXPECT_EQ(report.found[1].uncertainty, 0.8);
}

TEST(Uncertainty, BoxesOfTheSamplesAreScoredWhereTheyAreAskedFor) {
  UncertaintyScan scan{.detections = {car_at(0)}, .objects = {car_at(0, 6)}};
  // Lengths 1 to 10: the box that holds half of them is 5 long, that of 0.9 is 9 long.
  for (int length = 1; length <= 10; ++length) {
    scan.detections[0].samples.push_back(car_at(0, length).box);
  }
  EXPECT_TRUE(evaluate_uncertainty(std::vector{scan}).all.sample_boxes.empty());
  const auto report = evaluate_uncertainty(std::vector{scan}, {.sample_confidences = {0.5, 0.9}});
  ASSERT_EQ(report.all.sample_boxes.size(), 2u);
  EXPECT_EQ(report.all.sample_boxes[0].promised, 0.5);
  EXPECT_EQ(report.all.sample_boxes[0].contained, 0.0);
  EXPECT_EQ(report.all.sample_boxes[1].contained, 1.0);
  EXPECT_THAT(to_table(report), ::testing::ContainsRegex("samples p +promised"));
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json.at("all").at("sample_boxes").at(1).at("p"), 0.9);
}

TEST(Uncertainty, SamplesPromiseTheOverlapOfTheirBox) {
  // IoU of the box with its samples: 1, 1, 4 / 5, 4 / 8; with the objects: 1 and 4 / 6.
  UncertaintyScan scan{.detections = {car_at(0), car_at(20), car_at(40)},
                       .objects = {car_at(0), car_at(20, 6), car_at(40)}};
  scan.detections[0].samples = {car_at(0).box, car_at(0).box};
  scan.detections[1].samples = {car_at(20, 5).box, car_at(20, 8).box};
  const auto report = evaluate_uncertainty(std::vector{scan}, {.promised_ious = {0.4, 0.6, 0.75}});
  ASSERT_EQ(report.all.overlaps.size(), 3u);
  const double promised[] = {1.0, 0.75, 0.75}, kept[] = {1.0, 1.0, 0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(report.all.overlaps[i].promised, promised[i], kTiny) << i;
    EXPECT_NEAR(report.all.overlaps[i].kept, kept[i], kTiny) << i;
    EXPECT_EQ(report.all.overlaps[i].boxes, 2u) << "the third has no samples";
  }
  const auto json = nlohmann::json::parse(to_json(report)).at("all").at("overlaps");
  EXPECT_EQ(json.at(1).at("iou"), 0.6);
  EXPECT_EQ(json.at(1).at("promised"), 0.75);
  EXPECT_THAT(to_table(report), ::testing::ContainsRegex("IoU at least +promised +kept"));
  EXPECT_TRUE(evaluate_uncertainty(std::vector{half_a_length_off()}).all.overlaps.empty());
  EXPECT_THROW(evaluate_uncertainty({}, {.promised_ious = {1.5}}), InvalidArgument);
}

TEST(Uncertainty, RankingsAreThoseOfAllFoundObjects) {
  const RandomStream random(7, 0, 0);
  std::uint32_t draw = 0;
  std::vector<UncertaintyScan> scans;
  std::vector<double> uncertainty, iou;
  std::vector<bool> wrong;
  for (int i = 0; i < 200; ++i) {
    const double move = 1.9 * random.uniform(draw++);
    UncertaintyScan scan{.detections = {car_at(move)}, .objects = {car_at(0)}};
    scan.detections[0].uncertainty = move + 0.5 * random.uniform(draw++);
    uncertainty.push_back(*scan.detections[0].uncertainty);
    iou.push_back(geometry::overlap(scan.detections[0].box, scan.objects[0].box));
    wrong.push_back(iou.back() < 0.6);
    scans.push_back(std::move(scan));
  }
  const auto report = evaluate_uncertainty(scans, {.wrong_iou = 0.6});
  EXPECT_EQ(report.all.found.boxes, 200u);
  ASSERT_TRUE(report.all.found.roc_auc && report.all.found.spearman);
  EXPECT_NEAR(*report.all.found.roc_auc, *roc_auc(uncertainty, wrong), kTiny);
  EXPECT_NEAR(*report.all.found.spearman, *spearman_correlation(uncertainty, iou), kTiny);
  EXPECT_GT(*report.all.found.roc_auc, 0.8);
  EXPECT_LT(*report.all.found.spearman, -0.7);
}

// The paper's table of uncertainty measures takes quantile boxes for the prediction.
TEST(Uncertainty, RankingsOfQuantileBoxesAreOfTheseBoxes) {
  const RandomStream random(8, 0, 0);
  std::uint32_t draw = 0;
  std::vector<UncertaintyScan> scans;
  std::vector<double> uncertainty;
  std::map<double, std::vector<double>> iou;
  for (int i = 0; i < 200; ++i) {
    UncertaintyScan scan{.detections = {car_at(0)}, .objects = {car_at(0)}};
    Detection& detection = scan.detections[0];
    const double spread = random.uniform(draw++);
    detection.uncertainty = spread + 0.3 * random.uniform(draw++);
    detection.quantile_boxes = {{.q = 0.8, .box = car_at(0, 4 - 3.5 * spread).box},
                                {.q = 0.2, .box = car_at(0, 4 + 6 * spread).box}};
    for (const auto& box : detection.quantile_boxes) {
      iou[box.q].push_back(geometry::overlap(box.box, scan.objects[0].box));
    }
    uncertainty.push_back(*detection.uncertainty);
    scans.push_back(std::move(scan));
  }
  const auto report = evaluate_uncertainty(scans, {.wrong_iou = 0.5});
  EXPECT_FALSE(report.all.found.roc_auc) << "no own box is wrong";
  ASSERT_EQ(report.all.quantile_boxes.size(), 2u);
  for (const BoxLevel& level : report.all.quantile_boxes) {
    const auto& of_level = iou.at(level.level);
    std::vector<bool> wrong;
    for (const double one : of_level) wrong.push_back(one < 0.5);
    EXPECT_EQ(level.boxes, 200u);
    EXPECT_EQ(level.wrong, static_cast<std::size_t>(std::count(wrong.begin(), wrong.end(), true)));
    EXPECT_GT(level.wrong, 10u);
    EXPECT_NEAR(level.mean_iou, std::accumulate(of_level.begin(), of_level.end(), 0.0) / 200,
                kTiny);
    ASSERT_TRUE(level.roc_auc && level.spearman);
    EXPECT_NEAR(*level.roc_auc, *roc_auc(uncertainty, wrong), kTiny);
    EXPECT_NEAR(*level.spearman, *spearman_correlation(uncertainty, of_level), kTiny);
    EXPECT_LT(*level.spearman, -0.8);
  }
  const auto json = nlohmann::json::parse(to_json(report));
  const auto& last = json.at("all").at("quantile_boxes").at(1);
  EXPECT_EQ(last.at("q"), 0.8);
  EXPECT_EQ(last.at("wrong"), report.all.quantile_boxes[1].wrong);
  EXPECT_NEAR(last.at("spearman").get<double>(), *report.all.quantile_boxes[1].spearman, kTiny);
  EXPECT_THAT(to_table(report), ::testing::ContainsRegex("quantile q +boxes +wrong"));
}

// Objects drawn from the very distributions that the samples are drawn from.
TEST(Uncertainty, WhatTrueSamplesExpectComesTrue) {
  const RandomStream random(11, 0, 0);
  std::uint32_t draw = 0;
  std::vector<UncertaintyScan> scans;
  double variance = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double spread = 3.0 * random.uniform(draw++);
    const auto drawn = [&] { return car_at(spread * (2 * random.uniform(draw++) - 1)); };
    UncertaintyScan scan{.detections = {car_at(0)}, .objects = {drawn()}};
    scan.detections[0].uncertainty = spread + random.uniform(draw++);
    scan.detections[0].quantile_boxes = {{.q = 0.2, .box = car_at(0, 4 + spread).box}};
    for (int j = 0; j < 64; ++j) scan.detections[0].samples.push_back(drawn().box);
    const double chance = 1.0 - geometry::overlapping_share({.boxes = scan.detections[0].samples},
                                                            car_at(0).box, 0.5);
    variance += chance * (1.0 - chance);
    scans.push_back(std::move(scan));
  }
  const auto report = evaluate_uncertainty(scans, {.max_distance = 4.0, .wrong_iou = 0.5});
  ASSERT_EQ(report.all.quantile_boxes.size(), 1u);
  for (const RankedBoxes& ranked : {report.all.found, RankedBoxes(report.all.quantile_boxes[0])}) {
    ASSERT_TRUE(ranked.expected && ranked.expected->roc_auc && ranked.expected->chance_roc_auc);
    EXPECT_GT(ranked.expected->wrong, 300);
    EXPECT_NEAR(*ranked.expected->roc_auc, *ranked.roc_auc, 0.03);
    EXPECT_NEAR(*ranked.expected->chance_roc_auc, *ranked.chance_roc_auc, 0.03);
    EXPECT_GT(*ranked.expected->chance_roc_auc, *ranked.expected->roc_auc);
    EXPECT_GT(*ranked.chance_roc_auc, *ranked.roc_auc);
  }
  EXPECT_NEAR(report.all.found.expected->wrong, static_cast<double>(report.all.found.wrong),
              4 * std::sqrt(variance));
  const BoxLevel& level = report.all.quantile_boxes[0];
  ASSERT_TRUE(level.held);
  EXPECT_NEAR(*level.held, level.contained, 0.03);
  EXPECT_GT(level.contained, 0.1);
  EXPECT_LT(level.contained, 0.9);
  const auto json = nlohmann::json::parse(to_json(report)).at("all");
  EXPECT_EQ(json.at("expected").at("wrong").get<double>(), report.all.found.expected->wrong);
  EXPECT_EQ(json.at("quantile_boxes").at(0).at("expected").at("roc_auc").get<double>(),
            *report.all.quantile_boxes[0].expected->roc_auc);
  EXPECT_THAT(to_table(report), ::testing::HasSubstr("as the samples expect"));
}

TEST(Uncertainty, NothingIsExpectedUnlessEveryDetectionHasSamples) {
  auto scan = half_a_length_off();
  scan.detections[0].uncertainty = 0.5;
  scan.detections[0].samples = {car_at(0).box, car_at(2).box};
  scan.detections[0].quantile_boxes = {{.q = 0.2, .box = car_at(2).box}};
  const auto of_samples = evaluate_uncertainty(std::vector{scan}, {.wrong_iou = 0.5});
  EXPECT_NEAR(of_samples.all.found.expected->wrong, 0.5, kTiny);
  EXPECT_NEAR(of_samples.all.quantile_boxes.at(0).held.value(), 0.5, kTiny);
  auto unsampled = scan;
  unsampled.detections[0].samples.clear();
  const auto report = evaluate_uncertainty(std::vector{scan, unsampled});
  EXPECT_FALSE(report.all.found.expected);
  EXPECT_FALSE(report.all.found.chance_roc_auc);
  ASSERT_EQ(report.all.quantile_boxes.size(), 1u);
  EXPECT_FALSE(report.all.quantile_boxes[0].held);
  EXPECT_TRUE(nlohmann::json::parse(to_json(report)).at("all").at("expected").is_null());
}

TEST(Uncertainty, ClassesScoresAndDistanceDecideWhatCounts) {
  auto scan = half_a_length_off();
  scan.objects.push_back(car_at(30));
  scan.objects.back().label = "Tram";
  EXPECT_EQ(evaluate_uncertainty(std::vector{scan}).classes.size(), 2u);
  EXPECT_EQ(evaluate_uncertainty(std::vector{scan}, {.classes = {"Car"}}).all.objects, 1u);
  EXPECT_EQ(evaluate_uncertainty(std::vector{scan}).all.found.boxes, 1u);
  EXPECT_EQ(evaluate_uncertainty(std::vector{scan}, {.min_score = 0.95}).all.found.boxes, 0u);
  EXPECT_EQ(evaluate_uncertainty(std::vector{scan}, {.max_distance = 1.9}).all.found.boxes, 0u);
}

TEST(Uncertainty, WhatIsNotDefinedIsEmpty) {
  const auto none = evaluate_uncertainty({});
  EXPECT_EQ(none.all.found.boxes, 0u);
  EXPECT_EQ(none.all.found.mean_iou, 0.0);
  EXPECT_FALSE(none.all.found.roc_auc);
  const auto scan = half_a_length_off();
  const auto report = evaluate_uncertainty(std::vector{scan});
  EXPECT_FALSE(report.all.found.roc_auc);
  EXPECT_FALSE(report.all.found.spearman);
  EXPECT_TRUE(report.all.quantile_boxes.empty());
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_TRUE(json.at("all").at("roc_auc").is_null());
  EXPECT_THAT(to_table(report), ::testing::Not(::testing::HasSubstr("quantile q")));
  EXPECT_THAT(to_table(report), ::testing::HasSubstr("Car"));
}

TEST(Uncertainty, TextsHoldTheFigures) {
  auto scan = half_a_length_off();
  scan.detections[0].quantile_boxes = {{.q = 0.2, .box = car_at(0, 9).box}};
  const auto report = evaluate_uncertainty(std::vector{scan});
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json.at("protocol"), "uncertainty");
  EXPECT_EQ(json.at("classes").at("Car").at("quantile_boxes").at(0).at("q"), 0.2);
  EXPECT_EQ(json.at("classes").at("Car").at("quantile_boxes").at(0).at("contained"), 1.0);
  EXPECT_THAT(to_table(report), ::testing::ContainsRegex("quantile q +promised"));
}

TEST(Uncertainty, BadInputIsRefused) {
  auto scan = half_a_length_off();
  scan.detections[0].uncertainty = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(evaluate_uncertainty(std::vector{scan}), InvalidArgument);
  EXPECT_THROW(evaluate_uncertainty({}, {.min_score = 1.5}), InvalidArgument);
  EXPECT_THROW(evaluate_uncertainty({}, {.min_iog = -1}), InvalidArgument);
  EXPECT_THROW(evaluate_uncertainty({}, {.wrong_iou = std::nan("")}), InvalidArgument);
  std::vector<Detection> without = {car_at(0)};
  EXPECT_THROW(use_gaussian_uncertainty(without), InvalidArgument);
}

TEST(Uncertainty, GaussianMeasureIsTheDeviationOfSampledSizes) {
  std::vector<Detection> detections = {car_at(0)};
  detections[0].samples = {geometry::make_yaw_box({0, 0, 0}, {3, 1, 1}, 0),
                           geometry::make_yaw_box({0, 0, 0}, {5, 3, 2}, 0)};
  use_gaussian_uncertainty(detections);
  EXPECT_NEAR(*detections[0].uncertainty, (1.0 * 1.0 * 0.5) / (4.0 * 2.0 * 1.5), kTiny);
}

// Agresti and Coull (1998) and any statistics package: 8 of 10.
TEST(Uncertainty, ShareIntervalIsWilsons) {
  EXPECT_NEAR(share_interval(8, 10).low, 0.4901625, 1e-7);
  EXPECT_NEAR(share_interval(8, 10).high, 0.9433178, 1e-7);
  EXPECT_NEAR(share_interval(0, 10).high, 0.2775328, 1e-7);
  EXPECT_NEAR(share_interval(0, 10).low, 0.0, kTiny);
  EXPECT_DOUBLE_EQ(share_interval(10, 10).high, 1.0);
  EXPECT_EQ(share_interval(0, 0).high, 1.0);
}

}  // namespace
}  // namespace arbox::evaluation
