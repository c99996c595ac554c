#include "arbox/cli/picture_frame.h"

namespace arbox::cli {

Eigen::Matrix3d picture_from(io::SceneFrame frame, bool camera_looks_down) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (frame != io::SceneFrame::kCamera) return rotation;
  if (camera_looks_down) {
    rotation << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  } else {
    rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  }
  return rotation;
}

void turn(geometry::PointCloud& cloud, const Eigen::Matrix3d& rotation) {
  const Eigen::Matrix3f turned = rotation.cast<float>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Eigen::Map<Eigen::Vector3f> point(cloud.values.data() + i * cloud.columns());
    point = (turned * point).eval();
  }
}

void turn(std::vector<geometry::Detection>& detections, const Eigen::Matrix3d& rotation) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = rotation;
  const auto apply = [&](geometry::Box& box) { box = geometry::transformed(box, transform); };
  for (geometry::Detection& detection : detections) {
    apply(detection.box);
    for (auto& quantile : detection.quantile_boxes) apply(quantile.box);
    for (auto& confidence : detection.confidence_boxes) apply(confidence.box);
    for (geometry::Box& sample : detection.samples) apply(sample);
  }
}

}  // namespace arbox::cli
