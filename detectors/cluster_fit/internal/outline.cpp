#include "arbox/detectors/cluster_fit/internal/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace arbox::detectors::internal {
namespace {

constexpr double kOutlineEdge = 0.1;
constexpr double kLargestLength = 6.0;
constexpr double kLargestWidth = 2.7;

}  // namespace

bool larger_than_any_object(std::span<const Eigen::Vector3f> points) {
  Eigen::Vector2f low = points[0].head<2>(), high = low;
  for (const Eigen::Vector3f& point : points) {
    low = low.cwiseMin(point.head<2>());
    high = high.cwiseMax(point.head<2>());
  }
  return (high - low).norm() > std::hypot(kLargestLength, kLargestWidth);
}

bool larger_than_any_object(const Rectangle& rectangle) {
  const Eigen::Vector2d extent = rectangle.high - rectangle.low;
  return extent.maxCoeff() > kLargestLength || extent.minCoeff() > kLargestWidth;
}

std::vector<Eigen::Vector2d> outline_of(std::span<const Eigen::Vector3f> points) {
  std::vector<std::pair<std::int64_t, std::uint32_t>> order;
  order.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto x = static_cast<std::int64_t>(std::floor(points[i].x() / kOutlineEdge));
    const auto y = static_cast<std::int64_t>(std::floor(points[i].y() / kOutlineEdge));
    order.emplace_back(x * (std::int64_t{1} << 32) + y, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    while (end < order.size() && order[end].first == order[begin].first) {
      sum += points[order[end++].second].head<2>().cast<double>();
    }
    outline.push_back(sum / static_cast<double>(end - begin));
  }
  return outline;
}

}  // namespace arbox::detectors::internal
