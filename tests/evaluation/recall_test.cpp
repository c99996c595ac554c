#include "arbox/evaluation/recall.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "arbox/base/error.h"
#include "evaluation/kitti_cases.h"

namespace arbox::evaluation {
namespace {

using arbox::testing::false_alarm;
using arbox::testing::found;
using arbox::testing::made_object;
using io::KittiObject;

/// Moved along its length, so that of 4 metres `shift` do not overlap.
KittiObject moved(KittiObject object, double shift) {
  object.x += shift * std::cos(object.rotation_y);
  object.z -= shift * std::sin(object.rotation_y);
  return object;
}

TEST(Recall, CountsObjectsFoundAtEachOverlap) {
  const KittiObject car = made_object();
  // IoU (4 - s) / (4 + s): 0.6 at 1 m, 0.78 at 0.5 m, 0.33 at 2 m.
  std::vector<KittiFrame> frames;
  for (const double shift : {0.0, 0.5, 1.0, 2.0}) {
    frames.push_back({.labels = {car}, .predictions = {found(moved(car, shift), 0.9)}});
  }
  frames.push_back({.labels = {car}, .predictions = {found(car, 0.4)}});
  const RecallReport report = evaluate_recall(frames);
  EXPECT_EQ(report.frames, 5u);
  EXPECT_EQ(report.objects, 5u);
  EXPECT_EQ(report.detections, 4u);
  EXPECT_EQ(report.false_detections, 0u);
  ASSERT_EQ(report.found.size(), 2u);
  EXPECT_EQ(report.found[0].found, 3u);
  EXPECT_EQ(report.found[1].found, 2u);
  EXPECT_DOUBLE_EQ(report.found[0].recall, 0.6);
  EXPECT_LT(report.found[0].interval.low, 0.6);
  EXPECT_EQ(evaluate_recall(frames, {.min_score = 0.3}).found[0].found, 4u);
}

TEST(Recall, OnlyPlainlyVisibleObjectsCount) {
  KittiObject far = made_object("Car", 41.0), hidden = made_object(), cut = made_object();
  hidden.occlusion = 2;
  cut.truncation = 0.31;
  const KittiFrame frame{.labels = {far, hidden, cut, made_object("Van")}, .predictions = {}};
  EXPECT_EQ(evaluate_recall(std::vector{frame}).objects, 0u);
  EXPECT_EQ(evaluate_recall(std::vector{frame}, {.max_range = 50}).objects, 1u);
  EXPECT_EQ(evaluate_recall(std::vector{frame}, {.max_occlusion = 2}).objects, 1u);
  EXPECT_EQ(evaluate_recall(std::vector{frame}, {.label = "Van"}).objects, 1u);
}

TEST(Recall, WhatLooksLikeACarOrIsNotLabelledIsNotFalse) {
  const KittiObject van = made_object("Van");
  KittiObject region = made_object("DontCare");
  region.x = region.y = region.z = -1000;
  region.height = region.width = region.length = -1;
  region.left = 690;
  region.right = 900;
  const KittiFrame frame{.labels = {van},
                         .predictions = {found(made_object("Car"), 0.9), false_alarm(0.9)}};
  EXPECT_EQ(evaluate_recall(std::vector{frame}).false_detections, 1u);
  KittiFrame ignored = frame;
  ignored.labels.push_back(region);
  EXPECT_EQ(evaluate_recall(std::vector{ignored}).false_detections, 0u);
  EXPECT_EQ(evaluate_recall(std::vector{frame}, {.resembling = {"Car"}}).false_detections, 2u);
  const std::vector both{frame, ignored};
  EXPECT_DOUBLE_EQ(evaluate_recall(both).false_per_frame(), 0.5);
}

TEST(Recall, NothingIsAReportAndBadOverlapsAreRefused) {
  const RecallReport none = evaluate_recall({});
  EXPECT_EQ(none.objects, 0u);
  EXPECT_EQ(none.false_per_frame(), 0.0);
  EXPECT_EQ(none.found[0].interval.high, 1.0);
  EXPECT_THROW(evaluate_recall({}, {.overlaps = {0.0}}), InvalidArgument);
  EXPECT_THROW(evaluate_recall({}, {.overlaps = {1.1}}), InvalidArgument);
}

TEST(Recall, TextsHoldTheFigures) {
  const KittiObject car = made_object();
  const KittiFrame frame{.labels = {car}, .predictions = {found(car, 0.9)}};
  const RecallReport report = evaluate_recall(std::vector{frame});
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json.at("found").at(1).at("iou"), 0.7);
  EXPECT_EQ(json.at("found").at(1).at("found"), 1);
  EXPECT_NE(to_table(report).find("recall at IoU 0.50  1.000"), std::string::npos);
}

}  // namespace
}  // namespace arbox::evaluation
