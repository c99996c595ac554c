#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "arbox/simulation/street_stream.h"
#include "detectors/pv_rcnn/small_detector.h"

namespace arbox::detectors::pv_rcnn {
namespace {

void expect_usable(const geometry::Box& box) {
  EXPECT_TRUE(box.center.allFinite());
  EXPECT_TRUE(box.size.allFinite());
  EXPECT_GT(box.size.minCoeff(), 0);
  EXPECT_TRUE(box.rotation.coeffs().allFinite());
  EXPECT_NEAR(box.rotation.norm(), 1, 1e-6);
}

/// Scans of streets by a scanner, and how many points the detector looks at in all.
void expect_answers(simulation::LidarKind kind, const PvRcnn& detector, std::int64_t& points) {
  points = 0;
  for (std::uint64_t index = 0; index < 2; ++index) {
    simulation::StreetScanOptions options;
    options.lidar = kind;
    const auto cloud = simulation::street_scan(options, 11, index).cloud();
    const auto view = cloud.view();
    points += make_batch({&view, 1}, detector.options(), false, 0).points.size(0);
    const DetectionResult result = detector.detect(view, {.quantiles = {0.2}});
    EXPECT_EQ(result.dropped_points, 0);
    EXPECT_EQ(result.dropped_boxes, 0);
    EXPECT_FALSE(result.detections.empty());
    for (const geometry::Detection& detection : result.detections) {
      EXPECT_THAT(detection.score, testing::AllOf(testing::Ge(0), testing::Le(1)));
      expect_usable(detection.box);
      ASSERT_EQ(detection.quantile_boxes.size(), 1U);
      expect_usable(detection.quantile_boxes[0].box);
      ASSERT_TRUE(detection.uncertainty);
      EXPECT_THAT(*detection.uncertainty, testing::AllOf(testing::Ge(0), testing::Le(1)));
    }
  }
}

TEST(PvRcnnScanners, ScansOfFewerBeamsAreAnswered) {
  const PvRcnn detector = made_detector();
  std::int64_t full = 0, half = 0, quarter = 0;
  expect_answers(simulation::LidarKind::kHdl64, detector, full);
  expect_answers(simulation::LidarKind::kSpinning32, detector, half);
  expect_answers(simulation::LidarKind::kSpinning16, detector, quarter);
  EXPECT_LT(half, full);
  EXPECT_LT(quarter, half);
}

}  // namespace
}  // namespace arbox::detectors::pv_rcnn
