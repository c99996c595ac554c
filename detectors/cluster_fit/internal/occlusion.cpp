#include "arbox/detectors/cluster_fit/internal/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace arbox::detectors::internal {
namespace {

constexpr int kDirections = 1440;
constexpr int kLooked = 3;
constexpr double kInFront = 1.0;

int direction(float x, float y) {
  const float turn = std::atan2(y, x) / (2.0f * std::numbers::pi_v<float>)+0.5f;
  return std::min(kDirections - 1, static_cast<int>(turn * kDirections));
}

}  // namespace

OcclusionMap::OcclusionMap(std::span<const Eigen::Vector3f> points)
    : nearest_(kDirections, std::numeric_limits<float>::infinity()) {
  for (const Eigen::Vector3f& point : points) {
    float& nearest = nearest_[direction(point.x(), point.y())];
    nearest = std::min(nearest, point.head<2>().norm());
  }
}

bool OcclusionMap::hides(const Eigen::Vector2d& corner, const Eigen::Vector2d& centre) const {
  const double turn = centre.x() * corner.y() - centre.y() * corner.x();
  const int away = turn >= 0.0 ? 1 : -1;
  const int start = direction(static_cast<float>(corner.x()), static_cast<float>(corner.y()));
  for (int step = 1; step <= kLooked; ++step) {
    const int seen = (start + away * step + kDirections) % kDirections;
    if (nearest_[seen] < corner.norm() - kInFront) return true;
  }
  return false;
}

}  // namespace arbox::detectors::internal
