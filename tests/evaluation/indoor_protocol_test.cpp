#include "arbox/evaluation/indoor_protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/evaluation/internal/score_order.h"
#include "arbox/evaluation/report.h"

namespace arbox::evaluation {
namespace {

using geometry::Box;
using geometry::make_yaw_box;
using geometry::Overlap;

Box chair(double x, double length = 1.0) { return make_yaw_box({x, 0, 0}, {length, 1, 1}, 0.0); }

IndoorScene one_scene(std::vector<LabeledBox> truth, std::vector<LabeledBox> predictions) {
  return {.name = "room", .truth = std::move(truth), .predictions = std::move(predictions)};
}

IndoorScore at(const IndoorReport& report, const std::string& name, double threshold) {
  for (const IndoorClassResult& result : report.classes) {
    if (result.name == name) return result.scores.at(threshold_index(report, threshold));
  }
  ADD_FAILURE() << "no class " << name;
  return {};
}

TEST(IndoorProtocol, AreaUnderTheCurveByHand) {
  // In order of score: right, wrong, right, wrong. Recalls 1/3 and 2/3 at precisions 1 and 2/3.
  const IndoorReport report = evaluate_indoor(
      std::vector{one_scene({{"chair", chair(0)}, {"chair", chair(5)}, {"chair", chair(10)}},
                            {{"chair", chair(5), 0.7},
                             {"chair", chair(0), 0.9},
                             {"chair", chair(30), 0.8},
                             {"chair", chair(40), 0.1}})});
  EXPECT_NEAR(at(report, "chair", 0.25).ap, 100.0 * (1.0 / 3 + 1.0 / 3 * 2 / 3), 1e-9);
  EXPECT_NEAR(at(report, "chair", 0.25).recall, 100.0 * 2 / 3, 1e-9);
  EXPECT_NEAR(at(report, "chair", 0.5).ap, at(report, "chair", 0.25).ap, 1e-12);
}

TEST(IndoorProtocol, PrecisionIsTheBestAtAnyHigherRecall) {
  const IndoorReport report = evaluate_indoor(std::vector{
      one_scene({{"chair", chair(0)}, {"chair", chair(5)}},
                {{"chair", chair(30), 0.9}, {"chair", chair(0), 0.8}, {"chair", chair(5), 0.7}})});
  EXPECT_NEAR(at(report, "chair", 0.25).ap, 100.0 * 2 / 3, 1e-9);
}

TEST(IndoorProtocol, EachTrueBoxIsClaimedOnce) {
  const IndoorReport report = evaluate_indoor(std::vector{one_scene(
      {{"chair", chair(0)}, {"chair", chair(5)}},
      {{"chair", chair(0.05), 0.9}, {"chair", chair(0), 0.8}, {"chair", chair(5), 0.7}})});
  EXPECT_NEAR(at(report, "chair", 0.5).ap, 100.0 * (0.5 + 0.5 * 2 / 3), 1e-9);
}

TEST(IndoorProtocol, ABestBoxThatIsTakenIsNotReplacedByTheSecondBest) {
  // Both predictions overlap the box at 0 most; the box at 0.8 stays unclaimed.
  const IndoorReport report = evaluate_indoor(
      std::vector{one_scene({{"chair", chair(0)}, {"chair", chair(0.8)}},
                            {{"chair", chair(0), 0.9}, {"chair", chair(0.3), 0.8}})},
      {.thresholds = {0.1}});
  EXPECT_NEAR(at(report, "chair", 0.1).recall, 50.0, 1e-9);
}

TEST(IndoorProtocol, ThresholdsAreStrict) {
  const auto scenes =
      std::vector{one_scene({{"chair", chair(0)}}, {{"chair", chair(0, 2.0), 0.9}})};
  const IndoorReport report = evaluate_indoor(scenes);  // IoU is 0.5
  EXPECT_EQ(at(report, "chair", 0.5).ap, 0.0);
  EXPECT_NEAR(at(report, "chair", 0.45).ap, 100.0, 1e-9);
  EXPECT_NEAR(report.mean.ap, 100.0 * 9 / 19, 1e-9);
}

TEST(IndoorProtocol, IogDividesByTheTrueBoxAndChoosesByIt) {
  const auto wide = std::vector{one_scene({{"chair", chair(0)}}, {{"chair", chair(0, 4.0), 0.9}})};
  EXPECT_EQ(at(evaluate_indoor(wide), "chair", 0.25).ap, 0.0);
  EXPECT_NEAR(at(evaluate_indoor(wide, {.overlap = Overlap::kIog}), "chair", 0.95).ap, 100.0, 1e-9);
  const auto narrow =
      std::vector{one_scene({{"chair", chair(0, 4.0)}}, {{"chair", chair(0), 0.9}})};
  EXPECT_EQ(at(evaluate_indoor(narrow, {.overlap = Overlap::kIog}), "chair", 0.25).ap, 0.0);
}

TEST(IndoorProtocol, ScenesAndClassesAreKeptApart) {
  const std::vector<IndoorScene> scenes = {
      {.name = "a", .truth = {{"chair", chair(0)}}, .predictions = {{"table", chair(0), 0.9}}},
      {.name = "b", .truth = {{"table", chair(3)}}, .predictions = {{"chair", chair(0), 0.9}}}};
  const IndoorReport report = evaluate_indoor(scenes);
  EXPECT_EQ(at(report, "chair", 0.25).ap, 0.0);
  EXPECT_EQ(at(report, "table", 0.25).ap, 0.0);
}

TEST(IndoorProtocol, MeansAreOverClassesWithTruth) {
  const IndoorReport report =
      evaluate_indoor(std::vector{one_scene({{"chair", chair(0)}, {"table", chair(5)}},
                                            {{"chair", chair(0), 0.9}, {"lamp", chair(9), 0.9}})},
                      {.classes = {"lamp", "chair", "table"}});
  ASSERT_EQ(report.classes.size(), 3u);
  EXPECT_EQ(report.classes[0].name, "lamp");
  EXPECT_TRUE(report.classes[0].scores.empty());
  EXPECT_NEAR(report.class_means[threshold_index(report, 0.25)].ap, 50.0, 1e-9);
}

TEST(IndoorProtocol, RotatedBoxesOverlapExactly) {
  const Box turned = make_yaw_box({0, 0, 0}, {1, 1, 1}, 0.25 * 3.141592653589793);
  // A unit square and itself turned by 45 degrees share 2 (sqrt(2) - 1) = 0.8284: IoU 0.7071.
  const IndoorReport report =
      evaluate_indoor(std::vector{one_scene({{"chair", chair(0)}}, {{"chair", turned, 0.9}})},
                      {.thresholds = {0.7071, 0.7072}});
  EXPECT_NEAR(at(report, "chair", 0.7071).ap, 100.0, 1e-9);
  EXPECT_EQ(at(report, "chair", 0.7072).ap, 0.0);
}

std::vector<IndoorScene> random_scenes(int count) {
  std::vector<IndoorScene> scenes;
  for (int s = 0; s < count; ++s) {
    const RandomStream stream(17, static_cast<std::uint64_t>(s), 0);
    IndoorScene scene{.name = "scene" + std::to_string(s), .truth = {}, .predictions = {}};
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t draw = 20 * i;
      const std::string name = "class" + std::to_string(stream.below(draw, 3));
      const Box box =
          make_yaw_box({2.0 * i, stream.uniform(draw + 1), 0},
                       {stream.uniform(draw + 2, 0.5, 2.0), 1, 1}, stream.uniform(draw + 3, -3, 3));
      scene.truth.push_back({name, box});
      Box near = box;
      near.center.x() += 0.3 * stream.normal(draw + 4);
      near.center.z() += 0.1 * stream.normal(draw + 5);
      scene.predictions.push_back({name, near, stream.uniform(draw + 6)});
      near.center.y() += 0.2;
      scene.predictions.push_back({name, near, stream.uniform(draw + 7)});
    }
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

TEST(IndoorProtocol, DoesNotDependOnThreadsOrSceneOrder) {
  auto scenes = random_scenes(60);
  const std::string once = to_json(evaluate_indoor(scenes, {.threads = 1}));
  EXPECT_EQ(to_json(evaluate_indoor(scenes, {.threads = 3})), once);
  std::reverse(scenes.begin(), scenes.end());
  EXPECT_EQ(to_json(evaluate_indoor(scenes)), once);
}

TEST(IndoorProtocol, ApFallsWithTheThresholdAndStaysInRange) {
  const IndoorReport report = evaluate_indoor(random_scenes(60));
  for (const IndoorClassResult& result : report.classes) {
    for (std::size_t t = 0; t < result.scores.size(); ++t) {
      EXPECT_GE(result.scores[t].ap, 0.0);
      EXPECT_LE(result.scores[t].ap, result.scores[t].recall + 1e-9);
      EXPECT_LE(result.scores[t].recall, 100.0);
      if (t > 0) {
        EXPECT_LE(result.scores[t].ap, result.scores[t - 1].ap + 1e-9);
      }
    }
  }
}

TEST(IndoorProtocol, NothingGivesNothing) {
  EXPECT_TRUE(evaluate_indoor({}).classes.empty());
  const IndoorReport empty_rooms = evaluate_indoor(std::vector<IndoorScene>(3));
  EXPECT_EQ(empty_rooms.scenes, 3);
  EXPECT_TRUE(empty_rooms.classes.empty());
  const IndoorReport missed = evaluate_indoor(std::vector{one_scene({{"chair", chair(0)}}, {})});
  EXPECT_EQ(at(missed, "chair", 0.25).ap, 0.0);
}

TEST(IndoorProtocol, RefusesBadInput) {
  auto scenes = std::vector{one_scene({{"chair", chair(0)}}, {{"chair", chair(0), 0.9}})};
  EXPECT_THROW(evaluate_indoor(scenes, {.overlap = Overlap::kIntersection}), InvalidArgument);
  EXPECT_THROW(evaluate_indoor(scenes, {.thresholds = {1.0}}), InvalidArgument);
  EXPECT_THROW(evaluate_indoor(scenes, {.classes = {"a", "a"}}), InvalidArgument);
  EXPECT_THROW(threshold_index(evaluate_indoor(scenes), 0.33), InvalidArgument);
  scenes[0].predictions[0].score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(evaluate_indoor(scenes), InvalidArgument);
  scenes[0].predictions[0] = {"chair", chair(0, -1.0), 0.5};
  try {
    evaluate_indoor(scenes);
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("scene 'room', prediction row 0 (chair)"),
              std::string::npos);
  }
}

TEST(ScoreOrder, SortsAndIsAPermutation) {
  for (std::uint64_t object = 0; object < 300; ++object) {
    const RandomStream stream(9, object, 0);
    std::vector<double> scores(stream.below(0, 200));
    const std::uint32_t distinct = 1 + stream.below(1, 100);
    for (std::uint32_t i = 0; i < scores.size(); ++i) scores[i] = stream.below(2 + i, distinct);
    const auto order = descending_order(scores);
    std::vector<std::size_t> sorted(order);
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
    for (std::size_t i = 1; i < order.size(); ++i) {
      ASSERT_GE(scores[order[i - 1]], scores[order[i]]);
    }
  }
}

// Printed by NumPy 1.24: numpy.argsort(-numpy.array(scores)).
TEST(ScoreOrder, BreaksTiesAsNumpyDoes) {
  EXPECT_EQ(descending_order(std::vector<double>(16, 1.0)),
            (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(descending_order(std::vector<double>(20, 1.0)),
            (std::vector<std::size_t>{0, 17, 16, 15, 14, 13, 12, 11, 10, 9,
                                      8, 7,  6,  5,  4,  3,  2,  1,  18, 19}));
}

}  // namespace
}  // namespace arbox::evaluation
