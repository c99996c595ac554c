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

  /// measure() with what the sides tell.
  Rectangle measure_sides(double yaw) {
    Rectangle result = measure(yaw);
    const std::array<Ends, 2> ends = {ends_of(along_[0]), ends_of(along_[1])};
    std::array<Eigen::ArrayXf, 2> distance;
    for (int axis : {0, 1}) {
      distance[axis].setConstant(x_.size(), std::numeric_limits<float>::max());
      lower_to_sides(result, ends, axis, distance[axis]);
    }
    for (int axis : {0, 1}) {
      const auto nearer = distance[axis] < distance[1 - axis];
      result.share[axis] = nearer.cast<double>().mean();
      if (result.share[axis] > 0.0) {
        result.depth[axis] =
            nearer.select(distance[axis], 0.0f).mean() / static_cast<float>(result.share[axis]);
      }
    }
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

  /// Lowers `nearest` to the distances from the sides square to `axis` that face the sensor.
  void lower_to_sides(const Rectangle& rectangle, const std::array<Ends, 2>& ends, int axis,
                      Eigen::ArrayXf& nearest) const {
    // An end that the sensor does not face shows no side, unless the sensor stands inside.
    const bool inside = rectangle.sensor_side(0) == 0 && rectangle.sensor_side(1) == 0;
    const int facing = rectangle.sensor_side(axis);
    if (inside || facing < 0) nearest = nearest.min((along_[axis] - ends[axis].low).abs());
    if (inside || facing > 0) nearest = nearest.min((along_[axis] - ends[axis].high).abs());
  }

  double support(const Rectangle& rectangle, const std::array<Ends, 2>& ends) {
    nearest_.setConstant(x_.size(), std::numeric_limits<float>::max());
    for (int axis : {0, 1}) lower_to_sides(rectangle, ends, axis, nearest_);
    return (nearest_ * (-1.0f / kSideDepth)).exp().mean();
  }

  Eigen::Vector2d origin_;
  Eigen::ArrayXf x_, y_, nearest_;
  std::array<Eigen::ArrayXf, 2> along_;
  std::vector<float> lowest_, highest_;
};

constexpr double kQuarter = 0.5 * std::numbers::pi;

double wrap_quarter(double yaw) {
  const double wrapped = yaw - kQuarter * std::floor(yaw / kQuarter);
  return wrapped < kQuarter ? wrapped : 0.0;
}

/// The best heading within a step of that of `start`.
Rectangle refined(Search& search, const Rectangle& start, double step) {
  Rectangle best = start;
  double low = start.yaw - step, high = start.yaw + step;
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
  return best;
}

struct Headings {
  std::vector<Rectangle> rectangles;
  double step;
};

Headings measure_every(Search& search, double begin, double width, double step, bool with_end) {
  const int steps = std::max(2, static_cast<int>(std::ceil(width / step)));
  Headings result{.rectangles = {}, .step = width / steps};
  for (int i = 0; i < steps + (with_end ? 1 : 0); ++i) {
    result.rectangles.push_back(search.measure(begin + i * result.step));
  }
  return result;
}

bool less_support(const Rectangle& one, const Rectangle& other) {
  return one.support < other.support;
}

}  // namespace

Eigen::Vector2d Rectangle::corner(int end0, int end1) const {
  const double along = end0 ? high[0] : low[0], across = end1 ? high[1] : low[1];
  return {std::cos(yaw) * along - std::sin(yaw) * across,
          std::sin(yaw) * along + std::cos(yaw) * across};
}

Rectangle fit_l_shape(std::span<const Eigen::Vector2d> points, const LShapeSearch& options) {
  if (!options.around) return l_shapes(points, options.step, 1)[0];
  Search search(points);
  const auto [rectangles, step] = measure_every(search, *options.around - options.window,
                                                2.0 * options.window, options.step, true);
  return refined(search, *std::max_element(rectangles.begin(), rectangles.end(), less_support),
                 step);
}

std::vector<Rectangle> l_shapes(std::span<const Eigen::Vector2d> points, double step, int count) {
  Search search(points);
  const Headings every = measure_every(search, 0.0, kQuarter, step, false);
  const auto& all = every.rectangles;
  std::vector<Rectangle> peaks;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Rectangle& before = all[(i + all.size() - 1) % all.size()];
    const Rectangle& after = all[(i + 1) % all.size()];
    if (all[i].support > before.support && all[i].support >= after.support) peaks.push_back(all[i]);
  }
  // Equal everywhere, as for a single point.
  if (peaks.empty()) peaks.push_back(all[0]);
  const auto best_first = [&] {
    std::stable_sort(peaks.begin(), peaks.end(),
                     [](const auto& one, const auto& other) { return less_support(other, one); });
  };
  best_first();
  peaks.resize(std::min(peaks.size(), static_cast<std::size_t>(count)));
  for (Rectangle& peak : peaks) {
    peak = search.measure_sides(wrap_quarter(refined(search, peak, every.step).yaw));
  }
  best_first();
  return peaks;
}

}  // namespace arbox::detectors::internal
