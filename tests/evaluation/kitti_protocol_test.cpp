#include "arbox/evaluation/kitti_protocol.h"

#include <gtest/gtest.h>

#include <atomic>

#include <limits>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/evaluation/report.h"
#include "evaluation/kitti_cases.h"

namespace arbox::evaluation {
namespace {

using arbox::testing::false_alarm;
using arbox::testing::forty_frames;
using arbox::testing::found;
using arbox::testing::made_object;
using geometry::Overlap;
using io::KittiObject;

constexpr int kEasy = 0, kModerate = 1, kHard = 2;
constexpr double kTiny = 1e-9;

KittiClassResult score_cars(const std::vector<KittiFrame>& frames, KittiOptions options = {}) {
  options.classes = {*kitti_class("Car")};
  return evaluate_kitti(frames, options).classes.at(0);
}

TEST(KittiProtocol, AllFoundGivesAllButTheLastPoint) {
  const KittiClassResult result = score_cars(forty_frames());
  EXPECT_EQ(result.predictions, 40);
  for (const auto& curves : {result.image, result.birds_eye, result.box3d, result.orientation}) {
    ASSERT_TRUE(curves);
    for (const KittiCurve& curve : *curves) {
      EXPECT_EQ(curve.values[0], 1.0);
      EXPECT_EQ(curve.values[39], 1.0);
      EXPECT_EQ(curve.values[40], 0.0);
      EXPECT_NEAR(curve.r40(), 97.5, kTiny);
      EXPECT_NEAR(curve.r11(), 100.0 * 10 / 11, kTiny);
    }
  }
}

TEST(KittiProtocol, FalseAlarmOnTopCostsEveryPoint) {
  auto frames = forty_frames();
  frames[3].predictions.push_back(false_alarm(1.0));
  const KittiClassResult result = score_cars(frames);
  // After k finds precision is k / (k + 1); the best later one, 40 / 41, counts everywhere.
  EXPECT_NEAR((*result.box3d)[kEasy].r40(), 100.0 * 39 / 40 * 40 / 41, kTiny);
  EXPECT_NEAR((*result.image)[kHard].r11(), 100.0 * 10 / 11 * 40 / 41, kTiny);
}

TEST(KittiProtocol, FalseAlarmInTheMiddleCostsTheLaterPoints) {
  auto frames = forty_frames();
  frames[0].predictions.push_back(false_alarm(0.795));  // below 20 finds
  const KittiCurve curve = (*score_cars(frames).birds_eye)[kModerate];
  EXPECT_EQ(curve.values[19], 1.0);
  EXPECT_NEAR(curve.values[20], 40.0 / 41, kTiny);
  EXPECT_NEAR(curve.r40(), 100.0 * (19 + 20 * 40.0 / 41) / 40, kTiny);
}

TEST(KittiProtocol, FalseAlarmBelowTheLastFindIsFree) {
  auto frames = forty_frames();
  frames[0].predictions.push_back(false_alarm(0.1));
  EXPECT_NEAR((*score_cars(frames).box3d)[kEasy].r40(), 97.5, kTiny);
}

TEST(KittiProtocol, SecondBoxOnOneLabelIsAFalseAlarm) {
  auto frames = forty_frames();
  frames[0].predictions.push_back(found(frames[0].labels[0], 0.98));
  EXPECT_LT((*score_cars(frames).box3d)[kEasy].r40(), 97.5 - 0.1);
}

TEST(KittiProtocol, MissedLabelsLowerTheReach) {
  auto frames = forty_frames();
  for (int i = 20; i < 40; ++i) frames[i].predictions.clear();
  const KittiCurve curve = (*score_cars(frames).box3d)[kEasy];
  EXPECT_EQ(curve.values[19], 1.0);
  EXPECT_EQ(curve.values[20], 0.0);
  EXPECT_NEAR(curve.r40(), 100.0 * 19 / 40, kTiny);
}

TEST(KittiProtocol, FewLabelsReachFewPoints) {
  const auto frames = forty_frames();
  const KittiCurve curve = (*score_cars({frames[0], frames[1]}).box3d)[kEasy];
  EXPECT_NEAR(curve.r40(), 100.0 / 40, kTiny);
  EXPECT_NEAR(curve.r11(), 100.0 / 11, kTiny);
}

TEST(KittiProtocol, HarderLabelsNeitherCountNorPunish) {
  auto frames = forty_frames();
  KittiFrame occluded = frames[0];
  occluded.labels[0].occlusion = 2;
  occluded.predictions[0].score = 1.0;
  KittiFrame truncated = frames[0];
  truncated.labels[0].truncation = 0.4;
  truncated.predictions[0].score = 1.0;
  frames.push_back(occluded);
  frames.push_back(truncated);
  const KittiClassResult result = score_cars(frames);
  EXPECT_EQ(result.labels, (std::array<std::int64_t, 3>{40, 40, 42}));
  EXPECT_NEAR((*result.box3d)[kEasy].r40(), 97.5, kTiny);
  EXPECT_NEAR((*result.box3d)[kModerate].r40(), 97.5, kTiny);
}

TEST(KittiProtocol, LabelOfExactlyTheLeastHeightIsTooSmall) {
  KittiFrame frame = forty_frames()[0];
  frame.labels[0].bottom = frame.labels[0].top + 25.0;
  EXPECT_EQ(score_cars({frame}).labels, (std::array<std::int64_t, 3>{0, 0, 0}));
  frame.labels[0].bottom += 0.01;
  EXPECT_EQ(score_cars({frame}).labels, (std::array<std::int64_t, 3>{0, 1, 1}));
  frame.labels[0].bottom = frame.labels[0].top + 40.0;
  EXPECT_EQ(score_cars({frame}).labels, (std::array<std::int64_t, 3>{0, 1, 1}));
}

TEST(KittiProtocol, PredictionHeightIsComparedWithoutItsFraction) {
  for (const auto& [height, free] : {std::pair{24.9, true}, {25.0, false}, {25.9, false}}) {
    auto frames = forty_frames();
    KittiObject alarm = false_alarm(1.0);
    alarm.bottom = alarm.top + height;
    frames[0].predictions.push_back(alarm);
    const double r40 = (*score_cars(frames).box3d)[kModerate].r40();
    EXPECT_EQ(r40 > 97.4, free) << height;
    EXPECT_NEAR((*score_cars(frames).box3d)[kEasy].r40(), 97.5, kTiny) << height;
  }
}

TEST(KittiProtocol, NeighbouringClassIsNeutral) {
  auto frames = forty_frames();
  const KittiObject van = made_object("Van", 40.0);
  frames[0].labels.push_back(van);
  KittiObject mistaken = found(van, 1.0);
  mistaken.type = "Car";
  frames[0].predictions.push_back(mistaken);
  EXPECT_NEAR((*score_cars(frames).box3d)[kEasy].r40(), 97.5, kTiny);
  frames[0].labels.back().type = "Truck";
  EXPECT_NEAR((*score_cars(frames).box3d)[kEasy].r40(), 97.5 * 40 / 41, kTiny);
}

TEST(KittiProtocol, DontCareRegionsForgiveInTheImageOnly) {
  auto frames = forty_frames();
  const KittiObject alarm = false_alarm(1.0);
  frames[0].predictions.push_back(alarm);
  KittiObject region;
  region.type = "DontCare";
  region.left = alarm.left - 30.0;
  region.right = alarm.right - 20.0;  // 80 % of the prediction
  region.top = alarm.top - 10.0;
  region.bottom = alarm.bottom + 10.0;
  frames[0].labels.push_back(region);
  const KittiClassResult result = score_cars(frames);
  EXPECT_NEAR((*result.image)[kEasy].r40(), 97.5, kTiny);
  EXPECT_NEAR((*result.box3d)[kEasy].r40(), 97.5 * 40 / 41, kTiny);
  frames[0].labels.back().right = alarm.right - 40.0;  // 60 %: below the car's 0.7
  EXPECT_NEAR((*score_cars(frames).image)[kEasy].r40(), 97.5 * 40 / 41, kTiny);
}

TEST(KittiProtocol, IogAsksOnlyThatTheLabelIsCovered) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.predictions[0].length *= 2.0;  // IoU 0.5
  EXPECT_EQ((*score_cars(frames).box3d)[kEasy].r40(), 0.0);
  const KittiClassResult iog = score_cars(frames, {.overlap = Overlap::kIog});
  EXPECT_NEAR((*iog.box3d)[kEasy].r40(), 97.5, kTiny);
  EXPECT_EQ((*iog.birds_eye)[kEasy].r40(), 0.0);
  EXPECT_NEAR((*iog.image)[kEasy].r40(), 97.5, kTiny);
  const KittiClassResult both =
      score_cars(frames, {.overlap = Overlap::kIog, .birds_eye_overlap = Overlap::kIog});
  EXPECT_NEAR((*both.birds_eye)[kEasy].r40(), 97.5, kTiny);
}

TEST(KittiProtocol, IogDividesByTheLabel) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.predictions[0].length *= 0.6;
  EXPECT_EQ((*score_cars(frames, {.overlap = Overlap::kIog}).box3d)[kEasy].r40(), 0.0);
}

TEST(KittiProtocol, BirdsEyeDisregardsHeight) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.predictions[0].y += 1.0;
  const KittiClassResult result = score_cars(frames);
  EXPECT_NEAR((*result.birds_eye)[kEasy].r40(), 97.5, kTiny);
  EXPECT_EQ((*result.box3d)[kEasy].r40(), 0.0);
}

TEST(KittiProtocol, RotationTurnsTheFootprint) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.predictions[0].rotation_y += std::numbers::pi;
  EXPECT_NEAR((*score_cars(frames).box3d)[kEasy].r40(), 97.5, kTiny);
  for (KittiFrame& frame : frames) frame.predictions[0].rotation_y += std::numbers::pi / 2;
  EXPECT_EQ((*score_cars(frames).box3d)[kEasy].r40(), 0.0);
}

TEST(KittiProtocol, OrientationIsTheMeanCosine) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.predictions[0].alpha += std::numbers::pi / 2;
  const KittiClassResult result = score_cars(frames);
  EXPECT_NEAR((*result.orientation)[kEasy].r40(), 0.5 * 97.5, kTiny);
  EXPECT_NEAR((*result.image)[kEasy].r40(), 97.5, kTiny);
}

TEST(KittiProtocol, OneUnknownAlphaSwitchesOrientationOff) {
  auto frames = forty_frames();
  frames[7].predictions[0].alpha = -10.0;
  const KittiClassResult result = score_cars(frames);
  EXPECT_FALSE(result.orientation);
  EXPECT_TRUE(result.image);
}

TEST(KittiProtocol, MetricsWithoutFieldsAreAbsent) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) {
    KittiObject& flat = frame.predictions[0];
    flat.x = flat.y = flat.z = -1000.0;
    flat.length = flat.width = flat.height = -1.0;
  }
  const KittiClassResult flat = score_cars(frames);
  EXPECT_TRUE(flat.image);
  EXPECT_FALSE(flat.birds_eye);
  EXPECT_FALSE(flat.box3d);
  const KittiReport report = evaluate_kitti(frames);
  EXPECT_EQ(report.classes.at(1).predictions, 0);
  EXPECT_FALSE(report.classes.at(1).image);
}

TEST(KittiProtocol, ClassNamesAreComparedWithoutCase) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.predictions[0].type = "CAR";
  EXPECT_NEAR((*score_cars(frames).box3d)[kEasy].r40(), 97.5, kTiny);
}

TEST(KittiProtocol, AnyClassAndThresholdCanBeScored) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) {
    frame.labels[0].type = "Tram";
    frame.predictions[0].type = "Tram";
    frame.predictions[0].length *= 2.0;
  }
  const auto score = [&](double min_overlap) {
    const KittiClass tram{"Tram", {}, {0.5, 0.5, min_overlap}};
    return (*evaluate_kitti(frames, {.classes = {tram}}).classes.at(0).box3d)[kEasy].r40();
  };
  EXPECT_NEAR(score(0.49), 97.5, kTiny);
  EXPECT_EQ(score(0.51), 0.0);
}

TEST(KittiProtocol, NoFramesAndEmptyFramesGiveNoCurves) {
  for (const std::size_t frames : {0u, 3u}) {
    const KittiReport report = evaluate_kitti(std::vector<KittiFrame>(frames));
    EXPECT_EQ(report.frames, static_cast<std::int64_t>(frames));
    ASSERT_EQ(report.classes.size(), 3u);
    for (const KittiClassResult& result : report.classes) EXPECT_FALSE(result.image);
  }
}

TEST(KittiProtocol, PredictionsWithoutLabelsGiveZero) {
  auto frames = forty_frames();
  for (KittiFrame& frame : frames) frame.labels.clear();
  EXPECT_EQ((*score_cars(frames).box3d)[kHard].r40(), 0.0);
}

TEST(KittiProtocol, DoesNotDependOnThreadsOrFrameOrder) {
  auto frames = arbox::testing::random_frames(300);
  const std::string once = to_json(evaluate_kitti(frames, {.threads = 1}));
  EXPECT_EQ(to_json(evaluate_kitti(frames, {.threads = 2})), once);
  EXPECT_EQ(to_json(evaluate_kitti(frames, {.threads = 7})), once);
  const KittiReport forward = evaluate_kitti(frames);
  std::reverse(frames.begin(), frames.end());
  const KittiReport backward = evaluate_kitti(frames);
  for (std::size_t c = 0; c < forward.classes.size(); ++c) {
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_EQ((*forward.classes[c].box3d)[d].values, (*backward.classes[c].box3d)[d].values);
    }
    EXPECT_GT((*forward.classes[c].box3d)[kHard].r40(), 1.0);
  }
}

TEST(KittiProtocol, TellsOfEveryCellThatIsScored) {
  std::atomic<int> cells = 0;
  evaluate_kitti(arbox::testing::forty_frames(), {.threads = 2}, [&] { ++cells; });
  EXPECT_EQ(cells, 3 * kKittiCells);
}

TEST(KittiProtocol, RefusesBadInput) {
  auto frames = forty_frames();
  EXPECT_THROW(evaluate_kitti(frames, {.overlap = Overlap::kIntersection}), InvalidArgument);
  EXPECT_THROW(evaluate_kitti(frames, {.classes = {{"Car", {}, {0.7, 1.0, 0.7}}}}),
               InvalidArgument);
  EXPECT_THROW(evaluate_kitti(frames, {.classes = {*kitti_class("Car"), *kitti_class("car")}}),
               InvalidArgument);
  frames[2].predictions[0].z = std::numeric_limits<double>::quiet_NaN();
  try {
    evaluate_kitti(frames);
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("frame 2, prediction row 0"), std::string::npos);
  }
}

}  // namespace
}  // namespace arbox::evaluation
