#include "arbox/detectors/cluster_fit/internal/l_shape.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace arbox::detectors::internal {
namespace {

constexpr double kTrimmed = 0.01;
// Distance from a side at which a point's support has fallen to 1 / e.
constexpr float kSideDepth = 0.1f;
// The search ends this much of its first step from the best heading.
constexpr double kRefinement = 0.01;
constexpr double kGoldenRatio = 0.6180339887498949;

class Search {
 public:
  explicit Search(std::span<const Eigen::Vector2d> points)
      : origin_(points[0]), x_(points.size()), y_(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2f point = (points[i] - origin_).cast<float>();
      x_[static_cast<Eigen::Index>(i)] = point.x();
      y_[static_cast<Eigen::Index>(i)] = point.y();
    }
  }

  Rectangle measure(double yaw) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const auto cf = static_cast<float>(c), sf = static_cast<float>(s);
    along_[0] = cf * x_ + sf * y_;
    along_[1] = cf * y_ - sf * x_;
    Rectangle result{.yaw = yaw};
    const std::array<Ends, 2> ends = {ends_of(along_[0]), ends_of(along_[1])};
    const Eigen::Vector2d shift(c * origin_.x() + s * origin_.y(),
                                c * origin_.y() - s * origin_.x());
    for (int axis : {0, 1}) {
      result.low[axis] = shift[axis] + ends[axis].low;
      result.high[axis] = shift[axis] + ends[axis].high;
    }
    result.support = support(result, ends);
    return result;
  }

 private:
  struct Ends {
    float low, high;
  };

  /// The ends within which all but the trimmed points lie.
  Ends ends_of(const Eigen::ArrayXf& values) {
    const auto trim = static_cast<std::size_t>(kTrimmed * static_cast<double>(values.size()));
    if (trim == 0) return {values.minCoeff(), values.maxCoeff()};
    lowest_.assign(trim + 1, std::numeric_limits<float>::infinity());
    highest_.assign(trim + 1, -std::numeric_limits<float>::infinity());
    for (const float value : values) {
      insert(lowest_, value, std::less<>());
      insert(highest_, value, std::greater<>());
    }
    return {lowest_.back(), highest_.back()};
  }

  template <class Before>
  static void insert(std::vector<float>& extremes, float value, Before before) {
    if (!before(value, extremes.back())) return;
    std::size_t place = extremes.size() - 1;
    for (; place > 0 && before(value, extremes[place - 1]); --place) {
      extremes[place] = extremes[place - 1];
    }
    extremes[place] = value;
  }

  double support(const Rectangle& rectangle, const std::array<Ends, 2>& ends) {
    // An end that the sensor does not face shows no side, unless the sensor stands inside.
    const bool inside = rectangle.sensor_side(0) == 0 && rectangle.sensor_side(1) == 0;
    nearest_.setConstant(x_.size(), std::numeric_limits<float>::max());
    for (int axis : {0, 1}) {
      const int facing = rectangle.sensor_side(axis);
      if (inside || facing < 0) nearest_ = nearest_.min((along_[axis] - ends[axis].low).abs());
      if (inside || facing > 0) nearest_ = nearest_.min((along_[axis] - ends[axis].high).abs());
    }
    return (nearest_ * (-1.0f / kSideDepth)).exp().mean();
  }

  Eigen::Vector2d origin_;
  Eigen::ArrayXf x_, y_, nearest_;
  std::array<Eigen::ArrayXf, 2> along_;
  std::vector<float> lowest_, highest_;
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
  Rectangle left = search.measure(high - kGoldenRatio * (high - low));
  Rectangle right = search.measure(low + kGoldenRatio * (high - low));
  while (high - low > kRefinement * step) {
    if (left.support >= right.support) {
      high = right.yaw;
      right = std::exchange(left, search.measure(high - kGoldenRatio * (high - low)));
    } else {
      low = left.yaw;
      left = std::exchange(right, search.measure(low + kGoldenRatio * (high - low)));
    }
    const Rectangle& better = left.support >= right.support ? left : right;
    if (better.support > best.support) best = better;
  }
  return options.around ? best : search.measure(wrap_quarter(best.yaw));
}

}  // namespace arbox::detectors::internal
