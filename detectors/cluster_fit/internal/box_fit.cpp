#include "arbox/detectors/cluster_fit/internal/box_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "arbox/base/random.h"

namespace arbox::detectors::internal {
namespace {

// Objects stand on the ground: the lower 0.35 of the height holds 29 % of a car's returns (10 % of
// the cars: below 19 %).
constexpr double kLowPart = 0.35;
constexpr double kLowShare = 0.15;
// Points at which the evidence of a cluster counts half.
constexpr double kHalfPoints = 12.0;
constexpr double kTrimmedTop = 0.01;
constexpr std::uint32_t kPointPurpose = 1;
constexpr std::uint32_t kExtentPurpose = 2;
constexpr std::uint32_t kSizePurpose = 3;
// Normal, uniform and size draws of one sample.
constexpr std::uint32_t kExtentDraws = 8;

/// 1 if enough of the returns lie near the ground, as those of what stands on it do.
double standing(std::span<const Eigen::Vector3f> points, double top, double height) {
  const double floor = top - (1.0 - kLowPart) * height;
  const auto low = std::count_if(points.begin(), points.end(),
                                 [&](const auto& point) { return point.z() < floor; });
  return std::min(1.0, static_cast<double>(low) / static_cast<double>(points.size()) / kLowShare);
}

/// Stretches the rectangle to the sizes, at the ends that were not seen.
geometry::Box complete(const Hypothesis& hypothesis, int length_axis, const Eigen::Vector3d& size,
                       const Surroundings& surroundings) {
  const Rectangle& rectangle = hypothesis.rectangle;
  Eigen::Vector2d middle;
  for (int axis : {0, 1}) {
    const double missing =
        size[axis == length_axis ? 0 : 1] - (rectangle.high[axis] - rectangle.low[axis]);
    const auto& seen = hypothesis.end_seen[axis];
    double share_high = 0.5;
    if (seen[0] != seen[1]) {
      share_high = seen[0] ? 1.0 : 0.0;
    } else if (const int facing = rectangle.sensor_side(axis); facing != 0) {
      share_high = facing < 0 ? 1.0 : 0.0;
    }
    middle[axis] =
        0.5 * (rectangle.low[axis] + rectangle.high[axis]) + (share_high - 0.5) * missing;
  }
  const double c = std::cos(rectangle.yaw), s = std::sin(rectangle.yaw);
  const double x = c * middle[0] - s * middle[1], y = s * middle[0] + c * middle[1];
  const double quarter = 0.5 * std::numbers::pi;
  // In (-90, 90] degrees: the heading is known up to a half turn only.
  const double yaw = rectangle.yaw - (length_axis == 1 ? quarter : 0.0);
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

const Hypothesis& drawn(const std::vector<Hypothesis>& hypotheses, double u) {
  for (const Hypothesis& hypothesis : hypotheses) {
    if (u < hypothesis.share) return hypothesis;
    u -= hypothesis.share;
  }
  return hypotheses[0];
}

/// The outline with its points drawn anew, with replacement.
class Redrawn {
 public:
  Redrawn(const FittedObject& object, std::uint64_t seed)
      : outline_(object.outline), points_(outline_.size()), draw_(seed, object.id, kPointPurpose) {}

  const std::vector<Eigen::Vector2d>& points(std::uint32_t sample) {
    constexpr std::uint32_t kWords = 4;
    const auto count = static_cast<std::uint32_t>(outline_.size());
    const std::uint32_t blocks = (count + kWords - 1) / kWords;
    std::array<std::uint32_t, kWords> words = {};
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t word = i % kWords;
      if (word == 0) words = draw_.words(sample * blocks + i / kWords);
      points_[i] = outline_[(std::uint64_t{words[word]} * count) >> 32];
    }
    return points_;
  }

 private:
  const std::vector<Eigen::Vector2d>& outline_;
  std::vector<Eigen::Vector2d> points_;
  RandomStream draw_;
};

}  // namespace

FittedObject fit_object(std::span<const Eigen::Vector3f> points,
                        std::vector<Eigen::Vector2d> outline, std::span<const Rectangle> rectangles,
                        const Surroundings& surroundings) {
  FittedObject object{.outline = std::move(outline), .top = highest(points)};
  std::vector<Judgement> judgements;
  for (const Rectangle& rectangle : rectangles) {
    judgements.push_back(judge(rectangle, points.size(), object.top, surroundings));
  }
  std::size_t best = 0, prior = 0;
  for (std::size_t i = 0; i < judgements.size(); ++i) {
    for (std::size_t k = 0; k < kSizePriors.size(); ++k) {
      if (judgements[i].likelihood(k) > judgements[best].likelihood(prior)) {
        best = i;
        prior = k;
      }
    }
  }
  object.prior = &kSizePriors[prior];
  object.hypotheses = worth_a_draw(judgements, best, prior);

  const Judgement& judgement = judgements[best];
  const auto count = static_cast<double>(points.size());
  object.score = judgement.sum(prior) / judgement.total() *
                 standing(points, object.top, judgement.height) * count / (count + kHalfPoints);
  const Hypothesis& chosen = object.hypotheses[0];
  const Explanation size = explain(*object.prior, chosen, chosen.length_axis, judgement.height);
  object.box = complete(chosen, chosen.length_axis,
                        {size.length.mean(), size.width.mean(), size.height.mean()}, surroundings);
  return object;
}

std::vector<geometry::Box> sample_boxes(const FittedObject& object, int count, std::uint64_t seed,
                                        const Surroundings& surroundings) {
  const RandomStream draw(seed, object.id, kExtentPurpose);
  const RandomStream draw_size(seed, object.id, kSizePurpose);
  Redrawn redrawn(object, seed);
  std::vector<geometry::Box> boxes;
  for (int k = 0; k < count; ++k) {
    const auto sample = static_cast<std::uint32_t>(k);
    const std::uint32_t first = kExtentDraws * sample;
    const Hypothesis& from = drawn(object.hypotheses, draw.uniform(first + 6));
    Hypothesis other = from;
    other.rectangle = fit_l_shape(redrawn.points(sample),
                                  {.step = 0.035, .around = from.rectangle.yaw, .window = 0.14});
    for (int axis : {0, 1}) {
      other.rectangle.low[axis] += kExtentNoise * draw.normal(first + 2 * axis);
      other.rectangle.high[axis] += kExtentNoise * draw.normal(first + 2 * axis + 1);
      other.rectangle.high[axis] =
          std::max(other.rectangle.high[axis], other.rectangle.low[axis] + 1e-3);
    }
    const int length_axis = draw.uniform(first + 4) < from.length_is_axis0 ? 0 : 1;
    const double height = std::max(height_above_ground(object.top, other.rectangle, surroundings) +
                                       kGroundNoise * draw.normal(first + 5),
                                   1e-3);
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
