#include "arbox/detectors/cluster_fit/internal/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arbox::detectors::internal {
namespace {

// Below this sine between line of sight and face, the face tells nothing of its far end.
constexpr double kGrazing = 0.12;
// A face that the returns cover by this much is seen, whatever stands beside it.
constexpr double kFaceShown = 0.7;
// Clutter: extents spread evenly over 8 x 4 x 3 m, five times as common as objects.
constexpr double kClutter = 5.0 / (8.0 * 4.0 * 3.0);
// Returns per square metre of solid angle fall faster than the distance squared beyond this.
constexpr double kFadingRange = 30.0;
// Log likelihood that a rectangle gains with each unit of support.
constexpr double kSupportWeight = 20.0;
// Rectangles with a smaller share of the likelihood are not drawn.
constexpr double kLeastShare = 0.02;
// Mean distance of the returns behind its front or rear, and behind its flanks; how many
// independent returns a cluster counts for.
constexpr double kEndDepth = 0.3, kFlankDepth = 0.1, kSlopeWeight = 2.0;

Eigen::Vector2d centre_of(const Rectangle& rectangle) {
  return 0.5 * (rectangle.corner(0, 0) + rectangle.corner(1, 1));
}

EndsSeen visible_ends(const Rectangle& rectangle, const OcclusionMap& occlusion) {
  const Eigen::Vector2d centre = centre_of(rectangle);
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

SizePosterior size_along(const SizePrior& prior, int dimension, const Hypothesis& hypothesis,
                         int axis) {
  const double extent = hypothesis.rectangle.high[axis] - hypothesis.rectangle.low[axis];
  return {prior.mean[dimension],
          prior.deviation[dimension],
          prior.slack[dimension],
          std::max(extent, 1e-3),
          hypothesis.end_seen[axis][0] && hypothesis.end_seen[axis][1],
          kExtentNoise};
}

/// Moves the evidence for a class between its two axes by how far the returns lie behind the sides:
/// bonnets and rear windows slope, doors do not.
void split_by_slope(const Rectangle& rectangle, std::array<double, 2>& evidence) {
  std::array<double, 2> log = {};
  for (int length_axis : {0, 1}) {
    for (int axis : {0, 1}) {
      const double depth = axis == length_axis ? kEndDepth : kFlankDepth;
      log[length_axis] -=
          kSlopeWeight * rectangle.share[axis] * (std::log(depth) + rectangle.depth[axis] / depth);
    }
  }
  const double sum = evidence[0] + evidence[1];
  const double odds = evidence[0] > 0.0 ? evidence[1] / evidence[0] * std::exp(log[1] - log[0])
                                        : std::numeric_limits<double>::infinity();
  evidence = {sum / (1.0 + odds), sum - sum / (1.0 + odds)};
}

/// How well the number of returns fits the class, in (0, 1].
double count_fit(const SizePrior& prior, double count, double distance) {
  const double expected =
      prior.returns / (distance * distance) * std::min(1.0, kFadingRange / std::max(distance, 1.0));
  const double departure = std::log(count / expected) / prior.returns_deviation;
  return std::exp(-0.5 * departure * departure);
}

}  // namespace

double height_above_ground(double top, const Rectangle& rectangle,
                           const Surroundings& surroundings) {
  const Eigen::Vector2d centre = centre_of(rectangle);
  return std::max(top - surroundings.ground(centre.x(), centre.y()), 1e-3);
}

Explanation explain(const SizePrior& prior, const Hypothesis& hypothesis, int length_axis,
                    double height) {
  return {
      size_along(prior, 0, hypothesis, length_axis),
      size_along(prior, 1, hypothesis, 1 - length_axis),
      SizePosterior(prior.mean[2], prior.deviation[2], prior.slack[2], height, true, kGroundNoise)};
}

double Judgement::total() const {
  double total = kClutter;
  for (std::size_t k = 0; k < evidence.size(); ++k) total += sum(k);
  return total;
}

double Judgement::likelihood(std::size_t prior) const {
  return sum(prior) * std::exp(kSupportWeight * rectangle.support);
}

Judgement judge(const Rectangle& rectangle, std::size_t count, double top,
                const Surroundings& surroundings) {
  Judgement judgement{.rectangle = rectangle,
                      .end_seen = visible_ends(rectangle, *surroundings.occlusion),
                      .height = height_above_ground(top, rectangle, surroundings)};
  const double distance = centre_of(rectangle).norm();
  const Hypothesis hypothesis{.rectangle = rectangle, .end_seen = judgement.end_seen};
  for (std::size_t k = 0; k < kSizePriors.size(); ++k) {
    const SizePrior& prior = kSizePriors[k];
    const double common = prior.share * count_fit(prior, static_cast<double>(count), distance);
    for (int axis : {0, 1}) {
      judgement.evidence[k][axis] =
          common * std::exp(explain(prior, hypothesis, axis, judgement.height).log_evidence());
    }
    if (prior.sloping_ends) split_by_slope(rectangle, judgement.evidence[k]);
  }
  return judgement;
}

std::vector<Hypothesis> worth_a_draw(const std::vector<Judgement>& judgements, std::size_t best,
                                     std::size_t prior) {
  std::vector<Hypothesis> hypotheses;
  const auto add = [&](const Judgement& judgement) {
    const auto& evidence = judgement.evidence[prior];
    const double sum = judgement.sum(prior);
    hypotheses.push_back({.rectangle = judgement.rectangle,
                          .end_seen = judgement.end_seen,
                          .length_axis = evidence[1] > evidence[0] ? 1 : 0,
                          .length_is_axis0 = sum > 0.0 ? evidence[0] / sum : 0.5,
                          .share = judgement.likelihood(prior)});
  };
  add(judgements[best]);
  for (std::size_t i = 0; i < judgements.size(); ++i) {
    const double likelihood = judgements[i].likelihood(prior);
    if (i != best && likelihood > kLeastShare * hypotheses[0].share) add(judgements[i]);
  }
  double total = 0.0;
  for (const Hypothesis& hypothesis : hypotheses) total += hypothesis.share;
  for (Hypothesis& hypothesis : hypotheses) {
    hypothesis.share = total > 0.0 ? hypothesis.share / total : 1.0;
  }
  return hypotheses;
}

}  // namespace arbox::detectors::internal
