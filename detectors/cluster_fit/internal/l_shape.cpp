#include "arbox/detectors/cluster_fit/internal/l_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace arbox::detectors::internal {
namespace {

constexpr double kTrimmed = 0.01;
// Distance from a side at which a point's support has fallen to 1 / e.
constexpr double kSideDepth = 0.1;
constexpr double kGoldenRatio = 0.6180339887498949;

class Search {
 public:
  explicit Search(std::span<const Eigen::Vector2d> points)
      : points_(points),
        along_{std::vector<double>(points.size()), std::vector<double>(points.size())} {}

  Rectangle measure(double yaw) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      along_[0][i] = c * points_[i].x() + s * points_[i].y();
      along_[1][i] = c * points_[i].y() - s * points_[i].x();
    }
    Rectangle result{.yaw = yaw};
    for (int axis : {0, 1}) {
      std::vector<double>& order = scratch_;
      order = along_[axis];
      const auto trim = static_cast<std::ptrdiff_t>(kTrimmed * static_cast<double>(order.size()));
      std::nth_element(order.begin(), order.begin() + trim, order.end());
      result.low[axis] = order[trim];
      std::nth_element(order.begin(), order.end() - 1 - trim, order.end());
      result.high[axis] = *(order.end() - 1 - trim);
    }
    result.support = support(result);
    return result;
  }

 private:
  double support(const Rectangle& rectangle) const {
    std::array<std::array<double, 2>, 2> sides;
    for (int axis : {0, 1}) {
      const int facing = rectangle.sensor_side(axis);
      sides[axis] = {facing > 0 ? rectangle.high[axis] : rectangle.low[axis],
                     facing < 0 ? rectangle.low[axis] : rectangle.high[axis]};
    }
    // An end that the sensor does not face shows no side, unless the sensor stands inside.
    const bool inside = rectangle.sensor_side(0) == 0 && rectangle.sensor_side(1) == 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      double nearest = 1e9;
      for (int axis : {0, 1}) {
        if (rectangle.sensor_side(axis) == 0 && !inside) continue;
        nearest = std::min({nearest, std::abs(along_[axis][i] - sides[axis][0]),
                            std::abs(along_[axis][i] - sides[axis][1])});
      }
      sum += std::exp(-nearest / kSideDepth);
    }
    return sum / static_cast<double>(points_.size());
  }

  std::span<const Eigen::Vector2d> points_;
  std::array<std::vector<double>, 2> along_;
  std::vector<double> scratch_;
};

double wrap_quarter(double yaw) {
  const double quarter = 0.5 * std::numbers::pi;
  const double wrapped = yaw - quarter * std::floor(yaw / quarter);
  return wrapped < quarter ? wrapped : 0.0;
}

}  // namespace

Eigen::Vector2d Rectangle::corner(int end0, int end1) const {
  const double along = end0 ? high[0] : low[0], across = end1 ? high[1] : low[1];
  return {std::cos(yaw) * along - std::sin(yaw) * across,
          std::sin(yaw) * along + std::cos(yaw) * across};
}

Rectangle fit_l_shape(std::span<const Eigen::Vector2d> points, const LShapeSearch& options) {
  Search search(points);
  const double begin = options.around ? *options.around - options.window : 0.0;
  const double width = options.around ? 2.0 * options.window : 0.5 * std::numbers::pi;
  const int steps = std::max(2, static_cast<int>(std::ceil(width / options.step)));
  const double step = width / steps;
  Rectangle best = search.measure(begin);
  for (int i = 1; i < steps + (options.around ? 1 : 0); ++i) {
    const Rectangle candidate = search.measure(begin + i * step);
    if (candidate.support > best.support) best = candidate;
  }
  double low = best.yaw - step, high = best.yaw + step;
  while (high - low > 1e-3 * step) {
    const Rectangle left = search.measure(high - kGoldenRatio * (high - low));
    const Rectangle right = search.measure(low + kGoldenRatio * (high - low));
    if (left.support >= right.support) {
      high = right.yaw;
    } else {
      low = left.yaw;
    }
    const Rectangle& better = left.support >= right.support ? left : right;
    if (better.support > best.support) best = better;
  }
  return options.around ? best : search.measure(wrap_quarter(best.yaw));
}

}  // namespace arbox::detectors::internal
