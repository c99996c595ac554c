#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "arbox/detectors/pv_rcnn/model.h"
#include "arbox/io/point_cloud_file.h"
#include "detectors/pv_rcnn/small_detector.h"
#include "support/program.h"
#include "support/refusal.h"

namespace arbox::detectors::pv_rcnn {
namespace {

using ::arbox::testing::expect_one_line_error;
using ::arbox::testing::refusal;
using ::arbox::testing::run_arbox;
using ::arbox::testing::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;

// The random network's detections are cyclists for the most part.
const geometry::KnownSizes kFleet = {
    {"Car", {{"", {3.9, 1.6, 1.5}}}},
    {"Cyclist", {{"small", {1.6, 0.6, 1.7}}, {"large", {2.0, 0.7, 1.8}}}}};

/// Detections of one scan, without and with known sizes, in the same order.
struct Pair {
  std::vector<geometry::Detection> free, sized;
};

Pair detect_twice(const PvRcnn& detector, DetectionRequest request,
                  const geometry::KnownSizes& known = kFleet) {
  const auto scan = made_scan(1);
  Pair result;
  result.free = detector.detect(view_of(scan), request).detections;
  request.known_sizes = known;
  result.sized = detector.detect(view_of(scan), request).detections;
  EXPECT_FALSE(result.free.empty());
  EXPECT_EQ(result.free.size(), result.sized.size());
  return result;
}

bool is_one_of(const geometry::KnownSize& chosen, const std::vector<geometry::KnownSize>& known) {
  return std::any_of(known.begin(), known.end(), [&](const geometry::KnownSize& one) {
    return one.name == chosen.name && one.size == chosen.size;
  });
}

TEST(PvRcnnKnownSizes, BoxesOfTheseClassesHaveOneOfThem) {
  for (const char* box : {"mode", "mean", "pointwise"}) {
    const auto [free, sized] = detect_twice(made_detector({std::string("post.box=") + box}),
                                            {.quantiles = {0.2, 0.5}, .samples = true, .seed = 3});
    std::set<std::string> seen;
    for (std::size_t i = 0; i < free.size(); ++i) {
      const geometry::Detection &before = free[i], &after = sized[i];
      EXPECT_EQ(before.label, after.label);
      EXPECT_EQ(before.score, after.score);
      EXPECT_FALSE(before.known_size);
      const auto known = kFleet.find(after.label);
      if (!after.known_size) {
        EXPECT_EQ(before.box.center, after.box.center);
        EXPECT_EQ(before.box.size, after.box.size);
        EXPECT_EQ(before.uncertainty, after.uncertainty);
        continue;
      }
      ASSERT_NE(known, kFleet.end()) << after.label;
      seen.insert(after.label);
      EXPECT_TRUE(is_one_of(*after.known_size, known->second));
      EXPECT_EQ(after.box.size, after.known_size->size);
      ASSERT_EQ(after.samples.size(), 64U);
      for (const geometry::Box& sample : after.samples) {
        EXPECT_LT((sample.size - after.known_size->size).norm(), 1e-3);
      }
      ASSERT_EQ(after.quantile_boxes.size(), 2U);
      ASSERT_TRUE(after.uncertainty);
    }
    EXPECT_FALSE(seen.empty()) << box;
  }
}

TEST(PvRcnnKnownSizes, TheLikelierOneIsTakenWhateverTheOrder) {
  const PvRcnn detector = made_detector();
  const auto scan = made_scan(1);
  const geometry::Detection best = detector.detect(view_of(scan)).detections.at(0);
  const geometry::KnownSize own{"own", best.box.size}, other{"other", 1.15 * best.box.size};
  const auto with = [&](const std::vector<geometry::KnownSize>& known) {
    return detect_twice(detector, {}, {{best.label, known}}).sized;
  };
  const auto both = with({own, other}), turned = with({other, own});
  const auto of_own = with({own}), of_other = with({other});
  std::size_t compared = 0;
  for (std::size_t i = 0; i < both.size(); ++i) {
    EXPECT_EQ(both[i].known_size.has_value(), of_own[i].known_size || of_other[i].known_size);
    if (!of_own[i].log_density || !both[i].known_size || !of_own[i].known_size) continue;
    const bool only = !of_other[i].known_size || !of_other[i].log_density;
    const double lead = only ? 1 : *of_own[i].log_density - *of_other[i].log_density;
    if (std::abs(lead) < 0.02) continue;
    EXPECT_EQ(both[i].known_size->name, lead > 0 ? "own" : "other");
    EXPECT_EQ(both[i].box.size, turned[i].box.size);
    ++compared;
  }
  EXPECT_GT(compared, 0U);
}

TEST(PvRcnnKnownSizes, ImpossibleOnesLeaveTheDetectionAsItIs) {
  const auto [free, sized] =
      detect_twice(made_detector(), {}, {{"Cyclist", {{"ship", {90, 30, 40}}}}});
  for (std::size_t i = 0; i < free.size(); ++i) {
    EXPECT_FALSE(sized[i].known_size);
    EXPECT_EQ(free[i].box.size, sized[i].box.size);
  }
  // Compared by place and rotation alone, any size will do.
  const auto forced = detect_twice(made_detector({"post.known_sizes=given_size"}), {},
                                   {{"Cyclist", {{"ship", {90, 30, 40}}}}});
  for (const geometry::Detection& detection : forced.sized) {
    EXPECT_EQ(detection.known_size.has_value(), detection.label == "Cyclist");
  }
}

TEST(PvRcnnKnownSizes, HeadsOfIndependentComponentsTakeThemToo) {
  const std::vector<std::string> more = {"more_heads=[gaussian, discrete]",
                                         "more_head_options=['gaussian.hidden=[16]', "
                                         "'discrete.hidden=[16]']"};
  for (const char* head : {"gaussian", "discrete"}) {
    auto changes = more;
    changes.push_back(std::string("post.head=") + head);
    const auto [free, sized] = detect_twice(made_detector(changes), {.quantiles = {0.2}});
    std::size_t chosen = 0;
    for (const geometry::Detection& detection : sized) {
      if (!detection.known_size) continue;
      EXPECT_EQ(detection.box.size, detection.known_size->size);
      ++chosen;
    }
    EXPECT_GT(chosen, 0U) << head;
  }
}

TEST(PvRcnnKnownSizes, ConfidenceBoxesStayThoseOfTheCalibration) {
  evaluation::ConfidenceCalibration calibration;
  for (const char* label : {"Car", "Pedestrian", "Cyclist"}) {
    calibration.classes[label] = {{0.5, 500}, {1.0, 500}};
  }
  const auto [free, sized] = detect_twice(made_detector({}, calibration), {.confidences = {0.5}});
  for (std::size_t i = 0; i < free.size(); ++i) {
    ASSERT_EQ(free[i].confidence_boxes.size(), 1U);
    ASSERT_EQ(sized[i].confidence_boxes.size(), 1U);
    EXPECT_EQ(free[i].confidence_boxes[0].box.size, sized[i].confidence_boxes[0].box.size);
  }
}

TEST(PvRcnnKnownSizes, WhatCannotBeUsedIsRefusedBeforeAnyPointIsSeen) {
  const PvRcnn detector = made_detector();
  const auto refused = [](const PvRcnn& one, const geometry::KnownSizes& known) {
    return refusal([&] { one.detect({}, {.known_sizes = known}); });
  };
  EXPECT_THAT(refused(detector, {{"Caar", {{"", {4, 2, 1}}}}}),
              AllOf(HasSubstr("unknown class 'Caar'"), HasSubstr("nearest is 'Car'")));
  EXPECT_THROW(detector.detect({}, {.known_sizes = {{"Caar", {{"", {4, 2, 1}}}}}}), UnknownClass);
  EXPECT_THAT(refused(detector, {{"Car", {}}}), HasSubstr("at least one"));
  for (const double wrong : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(refused(detector, {{"Car", {{"", {4, wrong, 1}}}}}), HasSubstr("above zero"));
  }
  EXPECT_THAT(refused(made_detector({"more_heads=[pointwise]", "post.head=pointwise"}), kFleet),
              AllOf(HasSubstr("one box"), HasSubstr("these can: autoregressive")));
  EXPECT_THAT(
      refused(made_detector({"head.codec.order=center_size_rotation"}), kFleet),
      AllOf(HasSubstr("does not predict the size first"), HasSubstr("none of this model's heads")));
  EXPECT_THROW(
      made_detector({"more_heads=[pointwise]"}).detect_with_every_head({}, {.known_sizes = kFleet}),
      InvalidArgument);
}

TEST(PvRcnnKnownSizes, TheProgramTakesThemFromAFile) {
  const TemporaryDirectory folder;
  const std::string model = folder / "small.arbox", cloud = folder / "scan.pcd";
  const auto network = made_network({"more_heads=[pointwise]"});
  save_model(model, *network);
  const auto scan = made_scan(1);
  io::write_point_cloud(cloud, view_of(scan));
  const auto sizes = [&](const char* text) { return folder.write("fleet.csv", text).string(); };
  const auto best = PvRcnn(network).detect(view_of(scan)).detections.at(0);
  const auto& own = best.box.size;
  std::ostringstream table;
  table << std::setprecision(17) << "class,l,w,h,name\n"
        << best.label << ',' << own.x() << ',' << own.y() << ',' << own.z() << ",own\n"
        << best.label << ",90,90,90,\"a \"\"b\"\"\"\n";
  const std::string fleet = sizes(table.str().c_str());
  const auto found = run_arbox({"detect", cloud, "--model", model, "--score", "0", "--known-sizes",
                                fleet, "--quantile", "0.2"});
  ASSERT_EQ(found.exit_code, 0) << found.errors;
  std::size_t chosen = 0;
  const auto detections = nlohmann::json::parse(found.output).at("detections");
  for (const auto& detection : detections) {
    if (!detection.contains("known_size")) continue;
    ++chosen;
    EXPECT_EQ(detection.at("class"), best.label);
    EXPECT_EQ(detection.at("known_size"), detection.at("box").at("size"));
    EXPECT_EQ(detection.at("known_size_name"), "own");
  }
  EXPECT_GT(chosen, 0U);
  const auto refused = [&](const char* text, int exit_code, std::vector<std::string> parts,
                           const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"detect", cloud,           "--model",
                                      model,    "--known-sizes", sizes(text)};
    words.insert(words.end(), more.begin(), more.end());
    expect_one_line_error(run_arbox(words), exit_code, parts);
  };
  refused("Car 4 2 1\nVan 5 2 2\nVan 6 2 2\n", 1, {"fleet.csv:2", "'Van'", "Pedestrian"});
  refused("Car 4 2 1\n", 2, {"--known-sizes", "these can: autoregressive"},
          {"--head", "pointwise"});
}

}  // namespace
}  // namespace arbox::detectors::pv_rcnn
