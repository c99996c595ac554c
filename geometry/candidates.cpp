#include "arbox/geometry/internal/candidates.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::geometry::internal {
namespace {

// Larger than any rounding of an IoU, so that a bound never contradicts the overlap itself.
constexpr double kMargin = 1e-9;

OverlapSpace space_of(const NmsOptions& options) {
  if (options.space == "bev") return OverlapSpace::kBirdsEye;
  if (options.space == "3d") return OverlapSpace::k3d;
  if (options.space == "axis-aligned") return OverlapSpace::kAxisAligned;
  throw InvalidArgument("nms: space must be bev, 3d or axis-aligned, got '" + options.space + "'");
}

void require_length(std::size_t length, std::size_t boxes, const std::string& name) {
  if (length == boxes) return;
  throw InvalidArgument("nms: expected one " + name + " a box (" + std::to_string(boxes) +
                        "), got " + std::to_string(length));
}

void require_options(const NmsOptions& options) {
  const auto refuse = [](const std::string& problem) { throw InvalidArgument("nms: " + problem); };
  if (!(options.threshold >= 0.0 && options.threshold <= 1.0)) {
    refuse("threshold must be between 0 and 1, got " + std::to_string(options.threshold));
  }
  if (std::isnan(options.minimum_score)) refuse("minimum_score is not a number");
  if (options.pre_limit < 0 || options.post_limit < 0) refuse("limits must be at least 0");
  if (options.soft != "none" && options.soft != "linear" && options.soft != "gaussian") {
    refuse("soft must be none, linear or gaussian, got '" + options.soft + "'");
  }
  if (!(options.soft_sigma > 0.0 && std::isfinite(options.soft_sigma))) {
    refuse("soft_sigma must be finite and above 0, got " + std::to_string(options.soft_sigma));
  }
}

void require_scores(std::span<const double> scores, bool soft) {
  for (std::size_t row = 0; row < scores.size(); ++row) {
    if (std::isfinite(scores[row]) && !(soft && scores[row] < 0.0)) continue;
    throw InvalidArgument("nms: the score in row " + std::to_string(row) + " must be finite" +
                          (soft ? " and at least 0" : "") + ", got " + std::to_string(scores[row]));
  }
}

std::vector<std::int64_t> best_first(std::span<const double> scores, const NmsOptions& options) {
  std::vector<std::pair<double, std::int64_t>> rows;
  rows.reserve(scores.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    // Negated, so that ascending order is best first with ties by index.
    if (scores[i] >= options.minimum_score) rows.emplace_back(-scores[i], i);
  }
  std::sort(rows.begin(), rows.end());
  const auto limit = static_cast<std::size_t>(options.pre_limit);
  if (limit > 0 && rows.size() > limit) rows.resize(limit);
  std::vector<std::int64_t> order;
  order.reserve(rows.size());
  for (const auto& row : rows) order.push_back(row.second);
  return order;
}

/// Length that [-half, half] and [at - reach, at + reach] share.
double shared(double half, double at, double reach) {
  return std::max(0.0, std::min(half, at + reach) - std::max(-half, at - reach));
}

/// The overlap of `a` with the box along the axes of `a` that encloses `b`; both are level.
double enclosed_overlap(const OverlapBox& a, const OverlapBox& b) {
  const double dx = b.center[0] - a.center[0];
  const double dy = b.center[1] - a.center[1];
  const double ac = a.rotation[0], as = a.rotation[3];
  const double bc = b.rotation[0], bs = b.rotation[3];
  const double cosine = std::abs(ac * bc + as * bs);
  const double sine = std::abs(ac * bs - as * bc);
  return shared(a.half[0], ac * dx + as * dy, cosine * b.half[0] + sine * b.half[1]) *
         shared(a.half[1], ac * dy - as * dx, sine * b.half[0] + cosine * b.half[1]) *
         shared(a.half[2], b.center[2] - a.center[2], b.half[2]);
}

}  // namespace

Candidates::Candidates(std::span<const Box> boxes, std::span<const double> scores,
                       std::span<const int> classes, const NmsOptions& options) {
  require_options(options);
  const OverlapSpace space = space_of(options);
  require_length(scores.size(), boxes.size(), "score");
  if (options.class_aware) require_length(classes.size(), boxes.size(), "class");
  require_scores(scores, options.soft != "none");
  require_measurable(boxes, space, "nms");
  if (boxes.size() > INT32_MAX / 64) throw InvalidArgument("nms: more than 33 million boxes");
  order_ = best_first(scores, options);
  std::vector<Box> ordered;
  ordered.reserve(order_.size());
  scores_.reserve(order_.size());
  for (const std::int64_t i : order_) {
    ordered.push_back(boxes[i]);
    scores_.push_back(scores[i]);
    if (options.class_aware) classes_.push_back(classes[i]);
  }
  boxes_.emplace(ordered, space);
}

NearGrid Candidates::make_grid() const {
  double cell = 1.0;
  if (size() > 0) {
    const double* radius = boxes_->bounds(0).radius;
    std::vector<double> radii(radius, radius + size());
    std::nth_element(radii.begin(), radii.begin() + size() / 2, radii.end());
    cell = 2.0 * radii[size() / 2];
  }
  return {static_cast<std::size_t>(size()), cell};
}

double Candidates::squared_distance(std::int32_t i, std::int32_t j) const {
  const OverlapBounds a = boxes_->bounds(i), b = boxes_->bounds(j);
  const double dx = *a.x - *b.x, dy = *a.y - *b.y, dz = *a.z - *b.z;
  return dx * dx + dy * dy + dz * dz;
}

bool Candidates::may_exceed(std::int32_t i, std::int32_t j, double threshold) const {
  if (!classes_.empty() && classes_[i] != classes_[j]) return false;
  const OverlapBounds a = boxes_->bounds(i), b = boxes_->bounds(j);
  const double dx = *a.x - *b.x, dy = *a.y - *b.y;
  const double reach = *a.radius + *b.radius;
  if (dx * dx + dy * dy > reach * reach) return false;
  if (std::abs(*a.z - *b.z) > *a.reach + *b.reach) return false;
  const OverlapBox& p = box(i);
  const OverlapBox& q = box(j);
  double most = std::min(p.volume, q.volume);
  const double sum = p.volume + q.volume;
  const auto too_small = [&] { return most <= (threshold - kMargin) * (sum - most); };
  if (too_small()) return false;
  if (!p.level || !q.level) return true;
  most = std::min({most, enclosed_overlap(p, q), enclosed_overlap(q, p)});
  return !too_small();
}

}  // namespace arbox::geometry::internal
