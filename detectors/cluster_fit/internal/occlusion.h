#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace arbox::detectors::internal {

/// The nearest thing that stands on the ground in each direction around the sensor.
class OcclusionMap {
 public:
  explicit OcclusionMap(std::span<const Eigen::Vector3f> points);

  /// True if beside `corner`, on the side away from `centre`, something stands nearer to the
  /// sensor: the object may go on behind it.
  bool hides(const Eigen::Vector2d& corner, const Eigen::Vector2d& centre) const;

 private:
  std::vector<float> nearest_;
};

}  // namespace arbox::detectors::internal
