#include "arbox/detectors/cluster_fit/internal/box_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "arbox/base/random.h"

namespace arbox::detectors::internal {
namespace {

constexpr double kOutlineEdge = 0.1;
constexpr double kLargestLength = 6.0;
constexpr double kLargestWidth = 2.7;
// Measured spread of where the returns of one face begin (mirrors and bumpers stick out).
constexpr double kExtentNoise = 0.06;
// Below this sine between line of sight and face, the face tells nothing of its far end.
constexpr double kGrazing = 0.12;
// A face that the returns cover by this much is seen, whatever stands beside it.
constexpr double kFaceShown = 0.7;
// Clutter: extents spread evenly over 8 x 4 x 3 m, five times as common as objects.
constexpr double kClutter = 5.0 / (8.0 * 4.0 * 3.0);
// Returns per square metre of solid angle fall faster than the distance squared beyond this.
constexpr double kFadingRange = 30.0;
// Objects stand on the ground: the lower 0.35 of the height holds 29 % of a car's returns (10 % of
// the cars: below 19 %).
constexpr double kLowPart = 0.35;
constexpr double kLowShare = 0.15;
// Points at which the evidence of a cluster counts half.
constexpr double kHalfPoints = 12.0;
constexpr double kTrimmedTop = 0.01;
constexpr double kGroundNoise = 0.05;
constexpr std::uint32_t kPointPurpose = 1;
constexpr std::uint32_t kExtentPurpose = 2;
constexpr std::uint32_t kSizePurpose = 3;

using EndsSeen = std::array<std::array<bool, 2>, 2>;

EndsSeen visible_ends(const Rectangle& rectangle, const OcclusionMap& occlusion) {
  const Eigen::Vector2d centre = 0.5 * (rectangle.corner(0, 0) + rectangle.corner(1, 1));
  EndsSeen seen = {};
  for (int axis : {0, 1}) {
    const int other = 1 - axis;
    const int facing = rectangle.sensor_side(axis), face = rectangle.sensor_side(other);
    const double away = face > 0 ? -rectangle.high[other] : (face < 0 ? rectangle.low[other] : 0.0);
    const bool face_shows = away > kGrazing * centre.norm();
    for (int end : {0, 1}) {
      const bool end_faces = facing == (end == 1 ? 1 : -1);
      // The corner where the outline ends: behind the end if it faces us, else on the other face.
      const bool near_high = face > 0;
      const int across = end_faces ? !near_high : near_high;
      const Eigen::Vector2d corner =
          axis == 0 ? rectangle.corner(end, across) : rectangle.corner(across, end);
      const bool hidden = occlusion.hides(corner, centre);
      if (end_faces) {
        const double shown = rectangle.high[other] - rectangle.low[other];
        seen[axis][end] = shown > kFaceShown || !hidden;
      } else {
        seen[axis][end] = face_shows && !hidden;
      }
    }
  }
  return seen;
}

struct Explanation {
  SizePosterior length, width, height;
  double log_evidence() const {
    return length.log_evidence() + width.log_evidence() + height.log_evidence();
  }
};

SizePosterior size_along(const SizePrior& prior, int dimension, const FittedObject& object,
                         int axis) {
  const double extent = object.rectangle.high[axis] - object.rectangle.low[axis];
  return {prior.mean[dimension],
          prior.deviation[dimension],
          prior.slack[dimension],
          std::max(extent, 1e-3),
          object.end_seen[axis][0] && object.end_seen[axis][1],
          kExtentNoise};
}

double height_above_ground(const FittedObject& object, const Surroundings& surroundings) {
  const Eigen::Vector2d centre =
      0.5 * (object.rectangle.corner(0, 0) + object.rectangle.corner(1, 1));
  return std::max(object.top - surroundings.ground(centre.x(), centre.y()), 1e-3);
}

Explanation explain(const SizePrior& prior, const FittedObject& object, int length_axis,
                    double height) {
  return {
      size_along(prior, 0, object, length_axis), size_along(prior, 1, object, 1 - length_axis),
      SizePosterior(prior.mean[2], prior.deviation[2], prior.slack[2], height, true, kGroundNoise)};
}

/// How well the number of returns fits the class, in (0, 1].
double count_fit(const SizePrior& prior, double count, double distance) {
  const double expected =
      prior.returns / (distance * distance) * std::min(1.0, kFadingRange / std::max(distance, 1.0));
  const double departure = std::log(count / expected) / prior.returns_deviation;
  return std::exp(-0.5 * departure * departure);
}

/// 1 if enough of the returns lie near the ground, as those of what stands on it do.
double standing(std::span<const Eigen::Vector3f> points, double top, double height) {
  const double floor = top - (1.0 - kLowPart) * height;
  const auto low = std::count_if(points.begin(), points.end(),
                                 [&](const auto& point) { return point.z() < floor; });
  return std::min(1.0, static_cast<double>(low) / static_cast<double>(points.size()) / kLowShare);
}

/// Stretches the rectangle to the sizes, at the ends that were not seen.
geometry::Box complete(const FittedObject& object, int length_axis, const Eigen::Vector3d& size,
                       const Surroundings& surroundings) {
  Eigen::Vector2d middle;
  for (int axis : {0, 1}) {
    const double missing = size[axis == length_axis ? 0 : 1] -
                           (object.rectangle.high[axis] - object.rectangle.low[axis]);
    const auto& seen = object.end_seen[axis];
    double share_high = 0.5;
    if (seen[0] != seen[1]) {
      share_high = seen[0] ? 1.0 : 0.0;
    } else if (const int facing = object.rectangle.sensor_side(axis); facing != 0) {
      share_high = facing < 0 ? 1.0 : 0.0;
    }
    middle[axis] = 0.5 * (object.rectangle.low[axis] + object.rectangle.high[axis]) +
                   (share_high - 0.5) * missing;
  }
  const double c = std::cos(object.rectangle.yaw), s = std::sin(object.rectangle.yaw);
  const double x = c * middle[0] - s * middle[1], y = s * middle[0] + c * middle[1];
  const double quarter = 0.5 * std::numbers::pi;
  // In (-90, 90] degrees: the heading is known up to a half turn only.
  const double yaw = object.rectangle.yaw - (length_axis == 1 ? quarter : 0.0);
  return geometry::make_yaw_box({x, y, surroundings.ground(x, y) + 0.5 * size[2]}, size, yaw);
}

double highest(std::span<const Eigen::Vector3f> points) {
  std::vector<float> heights;
  heights.reserve(points.size());
  for (const auto& point : points) heights.push_back(point.z());
  const auto rank = heights.end() - 1 -
                    static_cast<std::ptrdiff_t>(kTrimmedTop * static_cast<double>(heights.size()));
  std::nth_element(heights.begin(), rank, heights.end());
  return *rank;
}

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

FittedObject fit_object(std::span<const Eigen::Vector3f> points,
                        std::vector<Eigen::Vector2d> outline, const Rectangle& rectangle,
                        const Surroundings& surroundings) {
  FittedObject object{.outline = std::move(outline), .rectangle = rectangle};
  object.end_seen = visible_ends(rectangle, *surroundings.occlusion);
  object.top = highest(points);
  const double height = height_above_ground(object, surroundings);

  const auto count = static_cast<double>(points.size());
  const double distance =
      0.5 * (object.rectangle.corner(0, 0) + object.rectangle.corner(1, 1)).norm();

  double best = -1.0, total = kClutter;
  for (const SizePrior& prior : kSizePriors) {
    std::array<double, 2> evidence;
    for (int axis : {0, 1}) {
      evidence[axis] = prior.share * count_fit(prior, count, distance) *
                       std::exp(explain(prior, object, axis, height).log_evidence());
    }
    const double sum = evidence[0] + evidence[1];
    total += sum;
    if (sum <= best) continue;
    best = sum;
    object.prior = &prior;
    object.length_axis = evidence[1] > evidence[0] ? 1 : 0;
    object.length_is_axis0 = sum > 0.0 ? evidence[0] / sum : 0.5;
  }
  object.score =
      best / total * standing(points, object.top, height) * count / (count + kHalfPoints);

  const Explanation chosen = explain(*object.prior, object, object.length_axis, height);
  object.box =
      complete(object, object.length_axis,
               {chosen.length.mean(), chosen.width.mean(), chosen.height.mean()}, surroundings);
  return object;
}

std::vector<geometry::Box> sample_boxes(const FittedObject& object, int count, std::uint64_t seed,
                                        const Surroundings& surroundings) {
  const RandomStream draw_point(seed, object.id, kPointPurpose);
  const RandomStream draw(seed, object.id, kExtentPurpose);
  const RandomStream draw_size(seed, object.id, kSizePurpose);
  const auto points = static_cast<std::uint32_t>(object.outline.size());
  std::vector<geometry::Box> boxes;
  std::vector<Eigen::Vector2d> redrawn(points);
  constexpr std::uint32_t kWords = 4;
  const std::uint32_t blocks = (points + kWords - 1) / kWords;
  std::array<std::uint32_t, kWords> words = {};
  for (int k = 0; k < count; ++k) {
    const auto sample = static_cast<std::uint32_t>(k);
    for (std::uint32_t i = 0; i < points; ++i) {
      const std::uint32_t word = i % kWords;
      if (word == 0) words = draw_point.words(sample * blocks + i / kWords);
      redrawn[i] = object.outline[(std::uint64_t{words[word]} * points) >> 32];
    }
    FittedObject other{.prior = object.prior, .end_seen = object.end_seen, .top = object.top};
    other.rectangle =
        fit_l_shape(redrawn, {.step = 0.035, .around = object.rectangle.yaw, .window = 0.14});
    const std::uint32_t first = 8 * sample;
    for (int axis : {0, 1}) {
      other.rectangle.low[axis] += kExtentNoise * draw.normal(first + 2 * axis);
      other.rectangle.high[axis] += kExtentNoise * draw.normal(first + 2 * axis + 1);
      other.rectangle.high[axis] =
          std::max(other.rectangle.high[axis], other.rectangle.low[axis] + 1e-3);
    }
    const int length_axis = draw.uniform(first + 4) < object.length_is_axis0 ? 0 : 1;
    const double height = std::max(
        height_above_ground(other, surroundings) + kGroundNoise * draw.normal(first + 5), 1e-3);
    const Explanation explained = explain(*object.prior, other, length_axis, height);
    boxes.push_back(complete(other, length_axis,
                             {explained.length.quantile(draw_size.uniform(3 * sample)),
                              explained.width.quantile(draw_size.uniform(3 * sample + 1)),
                              explained.height.quantile(draw_size.uniform(3 * sample + 2))},
                             surroundings));
  }
  return boxes;
}

}  // namespace arbox::detectors::internal
