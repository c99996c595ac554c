#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ATen/Context.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <thread>

#include "arbox/base/error.h"
#include "arbox/geometry/nms.h"
#include "arbox/geometry/overlap.h"
#include "detectors/pv_rcnn/small_detector.h"

namespace arbox::detectors::pv_rcnn {
namespace {

void expect_same(const DetectionResult& a, const DetectionResult& b, double tolerance,
                 double lifted = 0) {
  ASSERT_EQ(a.detections.size(), b.detections.size());
  for (std::size_t i = 0; i < a.detections.size(); ++i) {
    const geometry::Detection &one = a.detections[i], &other = b.detections[i];
    EXPECT_EQ(one.label, other.label);
    EXPECT_NEAR(one.score, other.score, tolerance);
    EXPECT_LE((one.box.center + Eigen::Vector3d(0, 0, lifted) - other.box.center).norm(),
              tolerance);
    EXPECT_LE((one.box.size - other.box.size).norm(), tolerance);
  }
}

TEST(PvRcnnDetector, GivesWhatIsAskedFor) {
  const PvRcnn detector = made_detector();
  const auto scan = made_scan(1);
  const auto result =
      detector.detect(view_of(scan), {.quantiles = {0.2, 0.5}, .samples = true, .seed = 3});
  ASSERT_FALSE(result.detections.empty());
  EXPECT_EQ(result.dropped_points, 0);
  double last = 1;
  for (const geometry::Detection& detection : result.detections) {
    EXPECT_LE(detection.score, last);
    last = detection.score;
    EXPECT_THAT(detection.label, testing::AnyOf("Car", "Pedestrian", "Cyclist"));
    ASSERT_EQ(detection.quantile_boxes.size(), 2U);
    EXPECT_EQ(detection.quantile_boxes[0].q, 0.2);
    EXPECT_EQ(detection.samples.size(), 64U);
    ASSERT_TRUE(detection.uncertainty);
    EXPECT_GE(*detection.uncertainty, 0);
    EXPECT_LE(*detection.uncertainty, 1);
    ASSERT_TRUE(detection.log_density);
    EXPECT_TRUE(std::isfinite(*detection.log_density));
  }
  const auto few = detector.detect(view_of(scan), {.score = last + 1e-9});
  EXPECT_LT(few.detections.size(), result.detections.size());
}

TEST(PvRcnnDetector, TheModeIsLikelierThanOtherBoxes) {
  const auto scan = made_scan(1);
  const auto mode = made_detector().detect(view_of(scan));
  const auto mean = made_detector({"post.box=mean"}).detect(view_of(scan));
  const auto pointwise = made_detector({"post.box=pointwise"}).detect(view_of(scan));
  const auto quantile = made_detector({"post.box=quantile"}).detect(view_of(scan));
  ASSERT_EQ(mode.detections.size(), mean.detections.size());
  ASSERT_EQ(mode.detections.size(), pointwise.detections.size());
  ASSERT_EQ(mode.detections.size(), quantile.detections.size());
  for (std::size_t i = 0; i < mode.detections.size(); ++i) {
    EXPECT_GE(*mode.detections[i].log_density + 1e-3, *mean.detections[i].log_density);
    EXPECT_GE(*mode.detections[i].log_density + 1e-3, *pointwise.detections[i].log_density);
    EXPECT_TRUE(quantile.detections[i].quantile_boxes.empty());
  }
}

TEST(PvRcnnDetector, ScoresKnowHowLikelyTheBoxIs) {
  const auto scan = made_scan(1);
  const auto plain = made_detector().detect(view_of(scan), {.samples = true, .seed = 4});
  const std::vector<std::string> overlap = {"post.scoring=overlap", "post.overlap_iou=0.3"};
  const auto ranked = made_detector(overlap).detect(view_of(scan), {.seed = 4});
  std::vector<double> expected, found;
  int lowered = 0;
  for (const geometry::Detection& detection : plain.detections) {
    double share = 0;
    for (const geometry::Box& sample : detection.samples) {
      share += geometry::overlap(sample, detection.box) >= 0.3 ? 1.0 / 64 : 0.0;
    }
    lowered += share < 1.0 - 1e-9 ? 1 : 0;
    expected.push_back(detection.score * share);
  }
  std::sort(expected.rbegin(), expected.rend());
  for (const geometry::Detection& detection : ranked.detections) found.push_back(detection.score);
  ASSERT_FALSE(expected.empty());
  EXPECT_THAT(found, testing::Pointwise(testing::DoubleNear(1e-12), expected));
  EXPECT_GT(lowered, 0);
}

TEST(PvRcnnDetector, SuppressionOfDecodedBoxesLeavesThemApart) {
  const auto scan = made_scan(1);
  const auto result = made_detector({"post.nms_on=decoded"}).detect(view_of(scan));
  ASSERT_FALSE(result.detections.empty());
  std::vector<geometry::Box> boxes;
  std::vector<double> scores;
  for (const auto& detection : result.detections) {
    boxes.push_back(detection.box);
    scores.push_back(detection.score);
  }
  EXPECT_EQ(geometry::nms(boxes, scores, {.threshold = 0.3}).kept.size(), boxes.size());
}

/// Of a grid of points over the box's footprint, the distance of the one nearest to the sensor.
double nearest_of_many(const geometry::Box& box) {
  double nearest = 1e9;
  for (double x = -0.5; x <= 0.5; x += 0.005) {
    for (double y = -0.5; y <= 0.5; y += 0.005) {
      const Eigen::Vector3d inside = box.size.cwiseProduct(Eigen::Vector3d(x, y, 0));
      const Eigen::Vector3d point = box.center + box.rotation * inside;
      nearest = std::min(nearest, point.head<2>().norm());
    }
  }
  return nearest;
}

TEST(PvRcnnDetector, BoxesThatReachTheSensorAreLeftOutIfAsked) {
  const auto scan = made_scan(1);
  const auto distances = [&](const std::vector<std::string>& options) {
    std::vector<double> result;
    for (const auto& found : made_detector(options).detect(view_of(scan)).detections) {
      result.push_back(nearest_of_many(found.box));
    }
    std::sort(result.begin(), result.end());
    return result;
  };
  const auto all = distances({"post.box=pointwise", "post.nms_iou=1"});
  const std::size_t half = all.size() / 2;
  ASSERT_GT(all[half], all[half - 1] + 0.02) << "another scan: two boxes are equally far";
  const double clearance = (all[half] + all[half - 1]) / 2;
  const auto clear = distances(
      {"post.box=pointwise", "post.nms_iou=1", "post.clearance=" + std::to_string(clearance)});
  EXPECT_EQ(clear, std::vector<double>(all.begin() + static_cast<long>(half), all.end()));
}

TEST(PvRcnnDetector, PointwiseHeadSaysThatItHasNoDistribution) {
  at::manual_seed(5);
  auto network = std::make_shared<Network>(small_options(false));
  unsettle(*network);
  const PvRcnn detector(network);
  const auto scan = made_scan(1);
  const auto result = detector.detect(view_of(scan), {.quantiles = {0.3}});
  ASSERT_FALSE(result.detections.empty());
  for (const geometry::Detection& detection : result.detections) {
    EXPECT_FALSE(detection.uncertainty);
    EXPECT_FALSE(detection.log_density);
    ASSERT_EQ(detection.quantile_boxes.size(), 1U);
    EXPECT_LT((detection.quantile_boxes[0].box.center - detection.box.center).norm(), 1e-3);
  }
}

TEST(PvRcnnDetector, NothingIsFoundInNothing) {
  const PvRcnn detector = made_detector();
  EXPECT_TRUE(detector.detect({}).detections.empty());
  const std::vector<float> behind = {-5, 0, 0, 0.5f, -6, 1, 0, 0.5f};
  EXPECT_TRUE(detector.detect(view_of(behind)).detections.empty());
  const std::vector<float> above = {5, 0, 30, 0.5f};
  EXPECT_TRUE(detector.detect(view_of(above)).detections.empty());
  const std::vector<float> one = {5, 0, -1, 0.5f};
  EXPECT_NO_THROW(detector.detect(view_of(one)));
}

TEST(PvRcnnDetector, PointsThatAreNotFiniteAreCounted) {
  const PvRcnn detector = made_detector();
  const auto scan = made_scan(1);
  auto broken = scan;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  broken.insert(broken.begin(), {nan, 1, 1, 0, 1, std::numeric_limits<float>::infinity(), 1, 0});
  const auto result = detector.detect(view_of(broken));
  EXPECT_EQ(result.dropped_points, 2);
  expect_same(result, detector.detect(view_of(scan)), 0);
  broken = scan;
  broken[3] = nan;
  EXPECT_NO_THROW(detector.detect(view_of(broken)));
}

TEST(PvRcnnDetector, IntensityMayHaveAnyScaleOrBeMissing) {
  const PvRcnn detector = made_detector();
  const auto scan = made_scan(1);
  for (const float full : {255.0f, 65535.0f}) {
    auto scaled = scan;
    float largest = 0;
    for (std::size_t i = 3; i < scan.size(); i += 4) largest = std::max(largest, scan[i]);
    for (std::size_t i = 3; i < scan.size(); i += 4) scaled[i] *= full / largest;
    auto unit = scan;
    for (std::size_t i = 3; i < scan.size(); i += 4) unit[i] /= largest;
    expect_same(detector.detect(view_of(scaled)), detector.detect(view_of(unit)), 1e-3);
  }
  std::vector<float> bare, zero = scan;
  for (std::size_t i = 0; i < scan.size(); i += 4) {
    bare.insert(bare.end(), scan.begin() + i, scan.begin() + i + 3);
    zero[i + 3] = 0;
  }
  expect_same(detector.detect(geometry::PointCloudView::packed(bare.data(), bare.size() / 3)),
              detector.detect(view_of(zero)), 0);
}

TEST(PvRcnnDetector, ManyPointsAreThinned) {
  const PvRcnn detector = made_detector({"voxels.max_points=2000", "voxels.max_voxels=500"});
  const auto scan = made_scan(1, 300000);
  const auto view = view_of(scan);
  const PointBatch batch = make_batch({&view, 1}, detector.options(), false, 0);
  EXPECT_LE(batch.points.size(0), 2000);
  EXPECT_GT(batch.points.size(0), 1500);
  EXPECT_LE(batch.voxels.size(), 500);
  EXPECT_NO_THROW(detector.detect(view));
}

TEST(PvRcnnDetector, ASensorAtAnotherHeightSeesTheSame) {
  const auto scan = made_scan(1);
  auto raised = scan;
  // Exact in float32, so that every point stays in its voxel.
  for (std::size_t i = 2; i < scan.size(); i += 4) raised[i] = std::round(raised[i] * 256) / 256;
  auto level = raised;
  for (std::size_t i = 2; i < scan.size(); i += 4) raised[i] -= 0.5f;
  const auto low = made_detector().detect(view_of(level));
  const auto high =
      made_detector({"trained_sensor_height=1.75", "sensor_height=2.25"}).detect(view_of(raised));
  expect_same(high, low, 1e-3, 0.5);
}

TEST(PvRcnnDetector, ThreadsShareADetector) {
  const PvRcnn detector = made_detector();
  const auto first = made_scan(1), second = made_scan(2);
  const auto alone_first = detector.detect(view_of(first));
  const auto alone_second = detector.detect(view_of(second));
  std::vector<DetectionResult> results(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < results.size(); ++i) {
    threads.emplace_back(
        [&, i] { results[i] = detector.detect(view_of(i % 2 == 0 ? first : second)); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < results.size(); ++i) {
    expect_same(results[i], i % 2 == 0 ? alone_first : alone_second, 0);
  }
}

std::set<std::string> running_threads() {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    names.insert(entry.path().filename());
  }
  return names;
}

/// Threads that OpenMP makes, and keeps, for the work of a thread.
std::ptrdiff_t helpers_of(const PvRcnn& detector, const geometry::PointCloudView& cloud,
                          int threads) {
  std::ptrdiff_t helpers = 0;
  std::thread([&] {
    const auto before = running_threads();
    detector.detect(cloud, {.quantiles = {0.2}, .threads = threads});
    for (const std::string& name : running_threads()) helpers += !before.contains(name);
  }).join();
  return helpers;
}

TEST(PvRcnnDetector, TakesAsManyThreadsAsItMay) {
  const auto scan = made_scan(1);
  for (const bool sparse : {true, false}) {
    auto network = std::make_shared<Network>(small_options(sparse, small_autoregressive()));
    const PvRcnn detector(network);
    EXPECT_EQ(helpers_of(detector, view_of(scan), 1), 0);
    EXPECT_THAT(helpers_of(detector, view_of(scan), 3),
                testing::AllOf(testing::Ge(1), testing::Le(2)));
    expect_same(detector.detect(view_of(scan), {.threads = 1}),
                detector.detect(view_of(scan), {.threads = 3}), 1e-3);
  }
}

TEST(PvRcnnDetector, HeadsAnswerForTheSameProposals) {
  const std::vector<std::string> more = {"more_heads=[gaussian, pointwise]",
                                         "more_head_options=['gaussian.hidden=[16]']"};
  const auto with = [&](const char* head) {
    auto changes = more;
    changes.push_back(std::string("post.head=") + head);
    return made_detector(changes);
  };
  const auto scan = made_scan(1);
  const auto all = made_detector(more).detect_with_every_head(view_of(scan));
  ASSERT_EQ(all.size(), 3U);
  const char* names[] = {"", "gaussian", "pointwise"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto alone = with(names[i]).detect(view_of(scan));
    ASSERT_FALSE(alone.detections.empty());
    expect_same(all[i], alone, 0);
    EXPECT_EQ(alone.detections[0].uncertainty.has_value(), i < 2);
  }
  EXPECT_NE(all[0].detections[0].box.center, all[1].detections[0].box.center);
  const auto bare = with("gaussian").detect(view_of(scan), {.uncertainty = false});
  expect_same(bare, all[1], 0);
  EXPECT_FALSE(bare.detections[0].uncertainty);
  EXPECT_THROW(with("gausian"), ConfigError);
  EXPECT_THROW(made_detector({"more_heads=[autoregressive]"}), ConfigError);
  EXPECT_THROW(made_detector({"more_head_options=['gaussian.hidden=[16]']"}), ConfigError);
}

TEST(PvRcnnDetector, RequestsOutOfRangeAreRefused) {
  const PvRcnn detector = made_detector();
  const auto scan = made_scan(1, 100);
  EXPECT_THROW(detector.detect(view_of(scan), {.quantiles = {1.5}}), InvalidArgument);
  EXPECT_THROW(detector.detect(view_of(scan), {.score = 2}), InvalidArgument);
  try {
    detector.detect(view_of(scan), {.confidences = {0.9}});
    FAIL() << "accepted";
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("calibration"));
  }
  EXPECT_THROW(PvRcnn(nullptr), InvalidArgument);
}

TEST(PvRcnnDetector, ConfidenceBoxesComeFromTheCalibration) {
  evaluation::ConfidenceCalibration calibration;
  for (const char* label : {"Car", "Pedestrian", "Cyclist"}) {
    calibration.classes[label] = {{0.5, 500}, {1.0, 500}};
  }
  const PvRcnn detector = made_detector({}, calibration);
  const auto scan = made_scan(1);
  const auto result = detector.detect(view_of(scan), {.confidences = {0.3, 0.9}});
  ASSERT_FALSE(result.detections.empty());
  for (const geometry::Detection& detection : result.detections) {
    ASSERT_EQ(detection.confidence_boxes.size(), 2U);
    EXPECT_GE(geometry::volume(detection.confidence_boxes[1].box),
              geometry::volume(detection.confidence_boxes[0].box) - 1e-9);
  }
}

TEST(PvRcnnDetector, BoxesThatAreNotFiniteAreCounted) {
  at::manual_seed(5);
  auto network = std::make_shared<Network>(small_options(true, small_autoregressive()));
  auto parameters = network->named_parameters();
  parameters["roi_head.reg_layers.4.bias"].detach().fill_(std::numeric_limits<float>::quiet_NaN());
  const auto scan = made_scan(1);
  const auto result = PvRcnn(network).detect(view_of(scan));
  EXPECT_TRUE(result.detections.empty());
  EXPECT_GT(result.dropped_boxes, 0);
  parameters["dense_head.conv_cls.bias"].detach().fill_(std::numeric_limits<float>::quiet_NaN());
  const auto nothing = PvRcnn(network).detect(view_of(scan));
  EXPECT_TRUE(nothing.detections.empty());
  EXPECT_GT(nothing.dropped_boxes, 0);
}

}  // namespace
}  // namespace arbox::detectors::pv_rcnn
