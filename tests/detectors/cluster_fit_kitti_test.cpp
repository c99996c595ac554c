#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "arbox/detectors/cluster_fit/cluster_fit.h"
#include "arbox/geometry/overlap.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/kitti_label.h"
#include "detectors/birds_eye_iou.h"
#include "support/program.h"

namespace arbox::detectors {
namespace {

struct Counts {
  int cars = 0, found = 0, right = 0, wrong = 0;
};

bool in_view(const geometry::Box& box, const io::KittiCalibration& calibration) {
  const Eigen::Vector3d pixel = io::project(box.center, calibration);
  return pixel.z() > 0.0 && pixel.x() >= 0.0 && pixel.x() < 1242.0 && pixel.y() >= 0.0 &&
         pixel.y() < 375.0 && box.center.head<2>().norm() < 40.0;
}

/// Counts cars against the labels; what meets any other labelled object counts neither way.
void count(const std::filesystem::path& training, const std::string& frame, Counts& counts) {
  const std::string bytes = io::read_file(training / "velodyne" / (frame + ".bin"));
  const auto cloud = geometry::PointCloudView::packed(reinterpret_cast<const float*>(bytes.data()),
                                                      bytes.size() / 16, {"intensity"});
  const auto calibration = io::read_kitti_calibration(training / "calib" / (frame + ".txt"));
  const auto labels = io::read_kitti_labels(training / "label_2" / (frame + ".txt"));
  std::vector<geometry::Box> cars, others;
  for (const auto& label : labels) {
    if (!io::has_box(label)) continue;
    const geometry::Box box = io::to_box(label, calibration);
    const bool counts_as_car = label.type == "Car" && box.center.head<2>().norm() < 40.0;
    (counts_as_car ? cars : others).push_back(box);
  }
  std::set<std::size_t> matched;
  for (const auto& detection : ClusterFit().detect(cloud, {.score = 0.5}).detections) {
    if (detection.label != "Car" || !in_view(detection.box, calibration)) continue;
    bool right = false, ignored = false;
    for (std::size_t i = 0; i < cars.size(); ++i) {
      right |= birds_eye_iou(detection.box, cars[i]) > 0.5 && matched.insert(i).second;
    }
    for (const auto& other : others) ignored |= birds_eye_iou(detection.box, other) > 0.3;
    counts.right += right;
    counts.wrong += !right && !ignored;
  }
  counts.cars += static_cast<int>(cars.size());
  counts.found += static_cast<int>(matched.size());
}

// Guards the measured quality (docs/detectors/cluster_fit.md) with some room below it.
TEST(ClusterFit, FindsCarsInRealScans) {
  ARBOX_REQUIRE_DATA(training, "kitti/training");
  Counts counts;
  for (const auto& entry : std::filesystem::directory_iterator(training / "velodyne")) {
    count(training, entry.path().stem().string(), counts);
  }
  ASSERT_GT(counts.cars, 20);
  EXPECT_GE(counts.found, 0.5 * counts.cars) << counts.found << " of " << counts.cars;
  EXPECT_GE(counts.right, 0.6 * (counts.right + counts.wrong))
      << counts.right << " right, " << counts.wrong << " wrong";
}

}  // namespace
}  // namespace arbox::detectors
