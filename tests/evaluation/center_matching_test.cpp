#include "arbox/evaluation/center_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::evaluation {
namespace {

using geometry::Detection;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

Detection at(double x, std::string label = "Car", double score = 0.5) {
  Detection detection;
  detection.label = std::move(label);
  detection.score = score;
  detection.box = geometry::make_yaw_box({x, 0, 0}, {4, 2, 1.5}, 0);
  return detection;
}

std::vector<std::pair<std::size_t, std::size_t>> pairs(const std::vector<CenterMatch>& matches) {
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (const auto& match : matches) result.emplace_back(match.detection, match.object);
  return result;
}

TEST(MatchByCenter, TheBestScoreChoosesFirstAndTakesTheNearest) {
  const std::vector objects{at(0), at(1.5)};
  const std::vector detections{at(0.9, "Car", 0.4), at(0.8, "Car", 0.9)};
  EXPECT_THAT(pairs(match_by_center(detections, objects)), ElementsAre(Pair(1, 1), Pair(0, 0)));
}

TEST(MatchByCenter, EqualScoresChooseInTheOrderOfTheList) {
  const std::vector objects{at(0)};
  const std::vector detections{at(1), at(0)};
  EXPECT_THAT(pairs(match_by_center(detections, objects)), ElementsAre(Pair(0, 0)));
}

TEST(MatchByCenter, OtherClassesAndFartherObjectsAreNotFound) {
  const std::vector objects{at(0, "Van"), at(2.01)};
  EXPECT_THAT(match_by_center(std::vector{at(0)}, objects), IsEmpty());
  EXPECT_THAT(pairs(match_by_center(std::vector{at(0.01)}, objects)), ElementsAre(Pair(0, 1)));
  EXPECT_THAT(pairs(match_by_center(std::vector{at(0)}, objects, 2.5)), ElementsAre(Pair(0, 1)));
}

TEST(MatchByCenter, NothingToMatchGivesNoMatches) {
  EXPECT_THAT(match_by_center({}, std::vector{at(0)}), IsEmpty());
  EXPECT_THAT(match_by_center(std::vector{at(0)}, {}), IsEmpty());
}

TEST(MatchByCenter, RandomScenesAgreeWithTakingTheBestOfAllPairsAgainAndAgain) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 12);
  for (int scene = 0; scene < 200; ++scene) {
    std::vector<Detection> objects, detections;
    for (int i = 0; i < 8; ++i) {
      objects.push_back(at(place(random), i % 2 ? "Car" : "Cyclist"));
      detections.push_back(at(place(random), i % 3 ? "Car" : "Cyclist", place(random) / 12));
    }
    std::vector<std::pair<std::size_t, std::size_t>> expected;
    std::vector<bool> asked(8), taken(8);
    for (int turn = 0; turn < 8; ++turn) {
      std::size_t best = 8;
      for (std::size_t d = 0; d < 8; ++d) {
        if (!asked[d] && (best == 8 || detections[d].score > detections[best].score)) best = d;
      }
      asked[best] = true;
      std::size_t nearest = 8;
      const auto distance = [&](std::size_t o) {
        return (objects[o].box.center - detections[best].box.center).norm();
      };
      for (std::size_t o = 0; o < 8; ++o) {
        if (taken[o] || objects[o].label != detections[best].label || distance(o) > 2) continue;
        if (nearest == 8 || distance(o) < distance(nearest)) nearest = o;
      }
      if (nearest == 8) continue;
      taken[nearest] = true;
      expected.emplace_back(best, nearest);
    }
    EXPECT_EQ(pairs(match_by_center(detections, objects)), expected);
  }
}

TEST(MatchByCenter, RefusesWhatIsNotFiniteAndBadDistances) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector good{at(0)};
  for (const auto& bad : {at(kNan), at(0, "Car", kNan)}) {
    EXPECT_THROW(match_by_center(std::vector{bad}, good), InvalidArgument);
    EXPECT_THROW(match_by_center(good, std::vector{bad}), InvalidArgument);
  }
  EXPECT_THROW(match_by_center(good, good, 0), InvalidArgument);
  try {
    match_by_center(good, good, kNan);
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), HasSubstr("distance above 0"));
  }
}

}  // namespace
}  // namespace arbox::evaluation
