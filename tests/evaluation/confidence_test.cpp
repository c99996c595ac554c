#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "arbox/base/error.h"
#include "arbox/evaluation/confidence_calibration.h"
#include "arbox/geometry/overlap.h"
#include "support/box_samples.h"
#include "support/statistics.h"

namespace arbox::evaluation {
namespace {

using geometry::Box;
using geometry::make_yaw_box;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ConfidenceFamilyOptions coarse() {
  return {.quantiles = {0.8, 0.6, 0.4, 0.2, 0.0}, .quantile_box = {.points_per_box = 8}};
}

double iog(const Box& box, const Box& truth) {
  return geometry::overlap(box, truth, {.measure = geometry::Overlap::kIog});
}

/// Samples of a head that is right on average but surer than it should be, and the true box.
struct MadeObject {
  std::vector<Box> samples;
  Box truth;
};

MadeObject made_object(std::uint64_t seed, double overconfidence) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double spread = 0.05 * std::exp(0.5 * normal(random));
  MadeObject object;
  object.truth = make_yaw_box({20 * normal(random), 20 * normal(random), normal(random)},
                              {4.0, 1.8, 1.5}, normal(random));
  const auto moved = [&](const Box& box, double amount) {
    const Eigen::Vector3d shift(normal(random), normal(random), normal(random));
    const Eigen::Vector3d stretch(normal(random), normal(random), normal(random));
    return Box{.center = box.center + amount * shift.cwiseProduct(box.size),
               .size = box.size.cwiseProduct((amount * stretch).array().exp().matrix()),
               .rotation = box.rotation};
  };
  const Box guess = moved(object.truth, spread);
  for (int i = 0; i < 8; ++i) {
    object.samples.push_back(moved(guess, spread / overconfidence));
  }
  return object;
}

TEST(ConfidenceFamily, LargerExtentsContainSmallerOnes) {
  std::mt19937_64 random(5);
  for (int object = 0; object < 30; ++object) {
    const auto samples =
        arbox::testing::scattered_samples(random, 12, object % 3 == 0 ? 1.0 : 0.2, object % 2 == 0);
    const ConfidenceFamily family({.boxes = samples}, coarse());
    Box before = family.box(0.1);
    for (const double extent : {0.2, 0.4, 0.5, 0.6, 0.8, 1.0, 1.01, 1.5, 4.0}) {
      const Box box = family.box(extent);
      for (const Eigen::Vector3d& corner : geometry::corners(before)) {
        EXPECT_TRUE(geometry::contains(box, corner, 2e-9)) << object << " " << extent;
      }
      before = box;
    }
  }
}

TEST(ConfidenceFamily, IsTheQuantileBoxesWhereTheseAreNested) {
  std::vector<Box> samples;
  for (const double size : {1.0, 2.0, 3.0, 4.0}) {
    samples.push_back({.center = {1, 2, 3}, .size = Eigen::Vector3d::Constant(size)});
  }
  const ConfidenceFamily family({.boxes = samples},
                                {.quantiles = {0.8, 0.6, 0.3, 0.0}, .quantile_box = {}});
  EXPECT_NEAR(family.box(0.2).size.x(), 1.0, 1e-9);
  EXPECT_NEAR(family.box(0.4).size.x(), 2.0, 1e-9);
  EXPECT_NEAR(family.box(0.55).size.x(), 2.5, 1e-9);
  EXPECT_NEAR(family.box(0.7).size.x(), 3.0, 1e-9);
  EXPECT_NEAR(family.box(1.0).size.x(), 4.0, 1e-9);
  EXPECT_NEAR(family.box(2.5).size.x(), 10.0, 1e-9);
  EXPECT_NEAR(family.box(0.01).size.x(), 1.0, 1e-9);
}

TEST(ConfidenceFamily, ExtentContainingIsTheLeast) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const MadeObject object = made_object(seed, 3.0);
    const ConfidenceFamily family({.boxes = object.samples}, coarse());
    const double extent = family.extent_containing(object.truth);
    ASSERT_TRUE(std::isfinite(extent));
    EXPECT_GT(iog(family.box(extent), object.truth), 0.95);
    if (extent > 0.21) {
      const double smaller = extent > 1.005 ? extent - 0.0101 : extent - 0.0251;
      EXPECT_LE(iog(family.box(smaller), object.truth), 0.95) << extent;
    }
  }
}

TEST(ConfidenceFamily, FarTruthIsNeverContained) {
  const std::vector<Box> samples(4, make_yaw_box({0, 0, 0}, {1, 1, 1}, 0));
  const ConfidenceFamily family({.boxes = samples}, coarse());
  EXPECT_EQ(family.extent_containing(make_yaw_box({100, 0, 0}, {1, 1, 1}, 0)), kInfinity);
  EXPECT_NEAR(family.extent_containing(make_yaw_box({4, 0, 0}, {1, 1, 1}, 0), 0.0), 7.01, 1e-9);
}

TEST(ConfidenceFamily, RefusesBadInput) {
  const std::vector<Box> samples = {make_yaw_box({0, 0, 0}, {1, 1, 1}, 0)};
  for (const std::vector<double>& qs : std::vector<std::vector<double>>{
           {}, {0.5}, {0.0, 0.5}, {0.5, 0.5, 0.0}, {1.0, 0.0}, {0.5, std::nan(""), 0.0}}) {
    EXPECT_THROW(ConfidenceFamily({.boxes = samples}, {.quantiles = qs, .quantile_box = {}}),
                 InvalidArgument);
  }
  EXPECT_THROW(ConfidenceFamily({.boxes = {}}), InvalidArgument);
  const ConfidenceFamily family({.boxes = samples}, coarse());
  for (const double extent : {0.0, -1.0, kInfinity, std::nan("")}) {
    EXPECT_THROW(family.box(extent), InvalidArgument);
  }
}

std::vector<CalibrationObject> view_of(const std::vector<MadeObject>& made, const char* label) {
  std::vector<CalibrationObject> objects;
  for (std::size_t i = 0; i < made.size(); ++i) {
    objects.push_back({.label = label,
                       .samples = {.boxes = made[i].samples, .object = i},
                       .truth = made[i].truth});
  }
  return objects;
}

// The head claims a third of its true error: without calibration its boxes hold far too little.
TEST(ConfidenceCalibration, KeepsThePromiseOverTwentySplits) {
  constexpr std::size_t kObjects = 400;
  std::vector<MadeObject> made;
  for (std::size_t i = 0; i < kObjects; ++i) made.push_back(made_object(1000 + i, 3.0));
  const auto objects = view_of(made, "Car");
  const CalibrationOptions options = {.family = coarse()};
  const std::vector<double> ps = {0.5, 0.9};
  std::vector<std::int64_t> covered(ps.size(), 0);
  std::int64_t tested = 0, uncalibrated = 0;
  for (std::uint64_t split = 0; split < 20; ++split) {
    std::vector<CalibrationObject> calibration_objects, fresh;
    std::mt19937_64 random(split);
    for (const CalibrationObject& object : objects) {
      (random() & 1 ? calibration_objects : fresh).push_back(object);
    }
    const auto calibration = calibrate_confidence(calibration_objects, "made", options);
    for (const CalibrationObject& object : fresh) {
      const auto boxes = confidence_boxes(calibration, "Car", object.samples, ps);
      ASSERT_EQ(boxes.size(), ps.size());
      for (std::size_t k = 0; k < ps.size(); ++k) {
        covered[k] += iog(boxes[k].box, object.truth) > kContainedIog;
      }
      uncalibrated +=
          iog(ConfidenceFamily(object.samples, coarse()).box(0.8), object.truth) > kContainedIog;
      ++tested;
    }
  }
  for (std::size_t k = 0; k < ps.size(); ++k) {
    const double coverage = static_cast<double>(covered[k]) / static_cast<double>(tested);
    EXPECT_GE(coverage, ps[k] - 0.01);
    EXPECT_LE(coverage, ps[k] + 0.06);
    EXPECT_GE(arbox::testing::binomial_lower_tail(covered[k], tested, ps[k]), 0.01);
  }
  EXPECT_LT(static_cast<double>(uncalibrated) / static_cast<double>(tested), 0.7);
}

TEST(ConfidenceCalibration, BoxesOfHigherProbabilityContainThoseOfLower) {
  std::vector<MadeObject> made;
  for (std::uint64_t i = 0; i < 60; ++i) made.push_back(made_object(i, 3.0));
  const auto objects = view_of(made, "Car");
  const auto calibration = calibrate_confidence(objects, "made", {.family = coarse()});
  const auto boxes =
      confidence_boxes(calibration, "Car", objects[0].samples, std::vector{0.1, 0.5, 0.8, 0.95});
  ASSERT_EQ(boxes.size(), 4u);
  for (std::size_t k = 1; k < boxes.size(); ++k) {
    for (const Eigen::Vector3d& corner : geometry::corners(boxes[k - 1].box)) {
      EXPECT_TRUE(geometry::contains(boxes[k].box, corner, 2e-9));
    }
  }
}

TEST(ConfidenceCalibration, ClassesAreApartAndFewObjectsPromiseLittle) {
  std::vector<MadeObject> made;
  for (std::uint64_t i = 0; i < 12; ++i) made.push_back(made_object(i, 3.0));
  auto objects = view_of(made, "Car");
  objects[3].label = "Cyclist";
  const auto calibration = calibrate_confidence(objects, "made", {.family = coarse()});
  EXPECT_EQ(calibration.objects("Car"), 11);
  EXPECT_EQ(calibration.objects("Cyclist"), 1);
  EXPECT_EQ(calibration.objects("Tram"), 0);
  EXPECT_TRUE(std::isfinite(calibration.extent("Car", 0.9)));
  EXPECT_EQ(calibration.extent("Car", 0.95), kInfinity);
  EXPECT_FALSE(confidence_box(calibration, "Car", objects[0].samples, 0.95));
  EXPECT_FALSE(confidence_box(calibration, "Tram", objects[0].samples, 0.5));
  EXPECT_TRUE(confidence_box(calibration, "Cyclist", objects[0].samples, 0.5));
  EXPECT_THROW(calibration.extent("Car", 1.0), InvalidArgument);
}

TEST(ConfidenceCalibration, ExtentEqualsTheConformalThreshold) {
  std::vector<MadeObject> made;
  for (std::uint64_t i = 0; i < 50; ++i) made.push_back(made_object(i, 3.0));
  const auto objects = view_of(made, "Car");
  std::vector<double> extents;
  for (const CalibrationObject& object : objects) {
    extents.push_back(ConfidenceFamily(object.samples, coarse()).extent_containing(object.truth));
  }
  const auto calibration = calibrate_confidence(objects, "made", {.family = coarse()});
  for (double p = 0.02; p < 1.0; p += 0.02) {
    EXPECT_EQ(calibration.extent("Car", p), conformal_threshold(extents, p));
  }
}

ConfidenceCalibration small_calibration() {
  return {
      .source = "made \"scans\", 3",
      .min_iog = 0.9,
      .family = {.quantiles = {0.7, 0.1, 0.0}, .quantile_box = {.points_per_box = 27, .seed = 9}},
      .classes = {{"Car", {{0.3, 4}, {1.07, 2}, {kInfinity, 1}}}, {"Van", {{1.0, 1}}}}};
}

TEST(CalibrationJson, ReadsBackAsTheSame) {
  const std::string text = to_json(small_calibration());
  const auto read = parse_confidence_calibration(text, "model.json");
  EXPECT_EQ(to_json(read), text);
  EXPECT_EQ(read.source, "made \"scans\", 3");
  EXPECT_EQ(read.family.quantiles, (std::vector<double>{0.7, 0.1, 0.0}));
  EXPECT_EQ(read.family.quantile_box.points_per_box, 27);
  for (const double p : {0.1, 0.5, 0.7, 0.8, 0.9}) {
    EXPECT_EQ(read.extent("Car", p), small_calibration().extent("Car", p)) << p;
  }
  EXPECT_EQ(read.objects("Car"), 7);
}

TEST(CalibrationJson, CalibrationWithoutObjectsIsKept) {
  const auto none = calibrate_confidence({}, "nothing");
  EXPECT_EQ(to_json(parse_confidence_calibration(to_json(none), "x")), to_json(none));
}

TEST(CalibrationJson, BadTextsAreRefusedWithTheirPlace) {
  const std::string good = to_json(small_calibration());
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
      parse_confidence_calibration(text, "model.json");
    } catch (const FormatError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(broken("confidence calibration", "model"), HasSubstr("format"));
  EXPECT_THAT(broken("\"version\": 1", "\"version\": 2"), HasSubstr("version"));
  EXPECT_THAT(broken("0.9,", "1.5,"), HasSubstr("min_iog"));
  EXPECT_THAT(broken("0.7,", "0.05,"), HasSubstr("quantiles"));
  EXPECT_THAT(broken("1.07", "0.2"), HasSubstr("extents above 0 that rise"));
  EXPECT_THAT(broken("\"uncontained\": 1", "\"uncontained\": -1"), HasSubstr("uncontained"));
  EXPECT_THAT(broken("\"points_per_box\": 27", "\"points_per_box\": 2.5"),
              HasSubstr("points_per_box"));
  EXPECT_THAT(broken("\"source\"", "\"origin\""), HasSubstr("model.json"));
  for (std::size_t length = 0; length + 2 < good.size(); length += 7) {
    EXPECT_THROW(parse_confidence_calibration(good.substr(0, length), "x"), FormatError) << length;
  }
}

}  // namespace
}  // namespace arbox::evaluation
