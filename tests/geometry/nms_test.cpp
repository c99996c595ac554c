#include "arbox/geometry/nms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "arbox/base/error.h"
#include "support/box_samples.h"
#include "support/nms_cases.h"
#include "support/refusal.h"

namespace {

using namespace arbox::geometry;
using namespace arbox::testing;
using arbox::InvalidArgument;
using ::testing::ElementsAre;

NmsOptions options_for(const std::string& space, double threshold) {
  return {.threshold = threshold, .space = space};
}

OverlapSpace space_of(const std::string& name) {
  if (name == "3d") return OverlapSpace::k3d;
  return name == "bev" ? OverlapSpace::kBirdsEye : OverlapSpace::kAxisAligned;
}

class NmsIn : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Spaces, NmsIn, ::testing::Values("bev", "3d", "axis-aligned"),
                         [](const auto& space) { return space.param.substr(0, 4); });

TEST_P(NmsIn, EqualsTestingEveryPair) {
  std::mt19937_64 random(3);
  for (const int clusters : {1, 5, 16, 350}) {
    const auto input = proposals(random, 350, clusters);
    for (const double threshold : {0.0, 0.01, 0.1, 0.5, 0.7, 0.9, 1.0}) {
      const auto expected = naive_nms(input, threshold, space_of(GetParam()));
      const auto result = nms(input.boxes, input.scores, options_for(GetParam(), threshold));
      EXPECT_EQ(result.kept, expected) << clusters << " clusters at " << threshold;
    }
  }
}

TEST_P(NmsIn, TheThreadsDoNotMatter) {
  std::mt19937_64 random(5);
  const auto input = proposals(random, 20000, 40);
  NmsOptions options = options_for(GetParam(), 0.6);
  options.threads = 1;
  const auto one = nms(input.boxes, input.scores, options);
  options.threads = 4;
  EXPECT_EQ(nms(input.boxes, input.scores, options).kept, one.kept);
  EXPECT_TRUE(std::is_sorted(one.scores.rbegin(), one.scores.rend()));
}

TEST(Nms, BoxesOfAnyRotationEqualTestingEveryPair) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  ScoredBoxes input;
  for (int object = 0; object < 12; ++object) {
    auto samples = scattered_samples(random, 30, 0.3, false);
    for (Box& box : samples) {
      if (object % 2 == 0) box.center.head<2>() *= 0.1;
      input.boxes.push_back(box);
      input.scores.push_back(unit(random));
    }
  }
  for (const double threshold : {0.05, 0.3, 0.6}) {
    EXPECT_EQ(nms(input.boxes, input.scores, options_for("3d", threshold)).kept,
              naive_nms(input, threshold, OverlapSpace::k3d));
  }
}

TEST(Nms, BoxesOfVeryDifferentSizesAndPlaces) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  ScoredBoxes input;
  for (int i = 0; i < 400; ++i) {
    const double scale = std::pow(10.0, 4 * unit(random) - 2);
    const double far = i % 50 == 0 ? 1e7 : 30.0;
    input.boxes.push_back(make_yaw_box({far * unit(random), far * unit(random), unit(random)},
                                       {scale, 2 * scale, 1}, 6 * unit(random)));
    input.scores.push_back(unit(random));
  }
  for (const double threshold : {0.0, 0.05, 0.3}) {
    EXPECT_EQ(nms(input.boxes, input.scores, options_for("bev", threshold)).kept,
              naive_nms(input, threshold, OverlapSpace::kBirdsEye));
  }
}

TEST(Nms, ClassesCountOnlyIfAsked) {
  std::mt19937_64 random(11);
  const auto input = proposals(random, 500, 8);
  std::vector<int> classes;
  for (std::size_t i = 0; i < input.boxes.size(); ++i) classes.push_back(i % 3);
  NmsOptions options{.threshold = 0.3, .class_aware = true};
  EXPECT_EQ(nms(input.boxes, input.scores, options, classes).kept,
            naive_nms(input, 0.3, OverlapSpace::kBirdsEye, classes));
  options.class_aware = false;
  EXPECT_EQ(nms(input.boxes, input.scores, options, classes).kept,
            naive_nms(input, 0.3, OverlapSpace::kBirdsEye));
}

TEST(Nms, TiesGoToTheLowerIndex) {
  const std::vector<Box> boxes(5);
  const std::vector<double> scores = {0.5, 0.9, 0.9, 0.9, 0.1};
  EXPECT_THAT(nms(boxes, scores).kept, ElementsAre(1));
  EXPECT_THAT(nms(boxes, scores, {.threshold = 1.0}).kept, ElementsAre(1, 2, 3, 0, 4));
}

TEST(Nms, LimitsAndMinimumScore) {
  std::vector<Box> boxes;
  for (int i = 0; i < 6; ++i) boxes.push_back(make_yaw_box({3.0 * (i / 2), 0, 0}, {2, 2, 2}, 0));
  const std::vector<double> scores = {0.9, 0.8, 0.7, 0.6, 0.5, 0.4};
  EXPECT_THAT(nms(boxes, scores).kept, ElementsAre(0, 2, 4));
  EXPECT_THAT(nms(boxes, scores, {.pre_limit = 3}).kept, ElementsAre(0, 2));
  EXPECT_THAT(nms(boxes, scores, {.post_limit = 2}).kept, ElementsAre(0, 2));
  EXPECT_THAT(nms(boxes, scores, {.minimum_score = 0.6}).kept, ElementsAre(0, 2));
  EXPECT_THAT(nms(boxes, scores, {.minimum_score = 2.0}).kept, ElementsAre());
}

/// Soft-NMS as the paper writes it.
NmsResult naive_soft_nms(const ScoredBoxes& input, const NmsOptions& options) {
  std::vector<double> scores = input.scores;
  std::vector<char> open(scores.size(), 1);
  NmsResult result;
  while (true) {
    int best = -1;
    for (std::size_t i = 0; i < scores.size(); ++i) {
      if (!open[i] || scores[i] < options.minimum_score) continue;
      if (best < 0 || scores[i] > scores[best]) best = static_cast<int>(i);
    }
    if (best < 0) return result;
    open[best] = 0;
    result.kept.push_back(best);
    result.scores.push_back(scores[best]);
    for (std::size_t i = 0; i < scores.size(); ++i) {
      if (!open[i]) continue;
      const double iou =
          overlap(input.boxes[best], input.boxes[i], {.space = OverlapSpace::kBirdsEye});
      if (options.soft == "gaussian") {
        scores[i] = std::exp(-iou * iou / options.soft_sigma) * scores[i];
      } else if (iou > options.threshold) {
        scores[i] = (1.0 - iou) * scores[i];
      }
    }
  }
}

TEST(SoftNms, EqualsTestingEveryPair) {
  std::mt19937_64 random(13);
  for (const std::string soft : {"linear", "gaussian"}) {
    for (const double minimum : {0.0, 0.05, 0.3}) {
      const auto input = proposals(random, 250, 6);
      const NmsOptions options{.threshold = 0.3, .minimum_score = minimum, .soft = soft};
      const auto expected = naive_soft_nms(input, options);
      const auto result = nms(input.boxes, input.scores, options);
      EXPECT_EQ(result.kept, expected.kept) << soft << ' ' << minimum;
      EXPECT_EQ(result.scores, expected.scores);
      NmsOptions limited = options;
      limited.post_limit = 5;
      EXPECT_EQ(nms(input.boxes, input.scores, limited).kept,
                std::vector<std::int64_t>(expected.kept.begin(), expected.kept.begin() + 5));
    }
  }
}

TEST(Nms, EmptyInputIsAResult) {
  EXPECT_TRUE(nms({}, {}).kept.empty());
  EXPECT_TRUE(nms({}, {}, {.soft = "gaussian"}).kept.empty());
  EXPECT_TRUE(nms({}, {}, {.class_aware = true}).kept.empty());
}

TEST(Nms, BadInputIsRefusedByName) {
  using ::testing::HasSubstr;
  const std::vector<Box> boxes(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto ask = [&](const std::vector<Box>& input, const std::vector<double>& scores,
                       const NmsOptions& options = {}) {
    return refusal([&] { nms(input, scores, options); });
  };
  EXPECT_THAT(ask(boxes, {1}), HasSubstr("one score a box (2), got 1"));
  EXPECT_THAT(ask(boxes, {1, nan}), HasSubstr("score in row 1"));
  EXPECT_THAT(ask(boxes, {1, -1}, {.soft = "linear"}), HasSubstr("at least 0"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.class_aware = true}), HasSubstr("one class a box"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.threshold = 1.5}), HasSubstr("threshold"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.threshold = nan}), HasSubstr("threshold"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.space = "2d"}), HasSubstr("'2d'"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.minimum_score = nan}), HasSubstr("minimum_score"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.pre_limit = -1}), HasSubstr("limits"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.soft = "hard"}), HasSubstr("'hard'"));
  EXPECT_THAT(ask(boxes, {1, 1}, {.soft = "gaussian", .soft_sigma = 0}), HasSubstr("soft_sigma"));
  auto bad = boxes;
  bad[1].size.z() = -1;
  EXPECT_THAT(ask(bad, {1, 1}), HasSubstr("row 1"));
  bad = boxes;
  bad[1].rotation = Quaternion(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
  EXPECT_THAT(ask(bad, {1, 1}), HasSubstr("row 1"));
  EXPECT_EQ(nms(bad, std::vector{1.0, 1.0}, {.space = "3d"}).kept.size(), 1u);
}

}  // namespace
