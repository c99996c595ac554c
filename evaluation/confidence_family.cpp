#include "arbox/evaluation/confidence_family.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "arbox/base/error.h"
#include "arbox/geometry/enclosing_box.h"
#include "arbox/geometry/overlap.h"

namespace arbox::evaluation {
namespace {

using geometry::Box;

constexpr double kTolerance = 1e-9;
constexpr int kGrowthSteps = 900;

constexpr int kBetweenSteps = 8;

/// Short in a file, and the same when read back.
double rounded(double extent) { return std::round(extent * 1e6) / 1e6; }

/// The least step above 0 that is enough; the last one is.
template <class Enough>
int least_step(int steps, const Enough& enough) {
  int too_small = 0, least = steps;
  while (least - too_small > 1) {
    const int middle = (too_small + least) / 2;
    (enough(middle) ? least : too_small) = middle;
  }
  return least;
}

double growth(int step) { return (100 + step) / 100.0; }

bool holds(const Box& outer, const Box& inner) {
  const auto corners = geometry::corners(inner);
  return std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& corner) {
    return geometry::contains(outer, corner, kTolerance);
  });
}

Box around(const Box& first, const Box& second) {
  std::vector<Eigen::Vector3d> points;
  for (const Box& box : {first, second}) {
    for (const Eigen::Vector3d& corner : geometry::corners(box)) points.push_back(corner);
  }
  const std::vector<geometry::Quaternion> rotations = {second.rotation, first.rotation};
  return *geometry::enclosing_box(points, rotations);
}

Box grown(Box box, double factor) {
  box.size *= factor;
  return box;
}

}  // namespace

void require_valid(const ConfidenceFamilyOptions& options) {
  const std::vector<double>& qs = options.quantiles;
  const bool falling = std::adjacent_find(qs.begin(), qs.end(), std::less_equal<>()) == qs.end();
  if (qs.empty() || !falling || qs.back() != 0.0 || !(qs.front() < 1.0)) {
    throw InvalidArgument(
        "confidence family: expected quantiles below 1 that fall strictly and end with 0");
  }
}

ConfidenceFamily::ConfidenceFamily(const geometry::BoxSamples& samples,
                                   const ConfidenceFamilyOptions& options) {
  require_valid(options);
  for (const geometry::QuantileBox& quantile :
       geometry::quantile_boxes(samples, options.quantiles, options.quantile_box)) {
    const bool nested = boxes_.empty() || holds(quantile.box, boxes_.back());
    boxes_.push_back(nested ? quantile.box : around(boxes_.back(), quantile.box));
    extents_.push_back(1.0 - quantile.q);
  }
}

geometry::Box ConfidenceFamily::box(double extent) const {
  if (!(extent > 0.0 && std::isfinite(extent))) {
    throw InvalidArgument("ConfidenceFamily::box: expected a finite extent above 0, got " +
                          std::to_string(extent));
  }
  if (extent > 1.0) return grown(boxes_.back(), extent);
  const auto place = std::lower_bound(extents_.begin(), extents_.end(), extent);
  const auto next = static_cast<std::size_t>(place - extents_.begin());
  if (next == 0) return boxes_.front();
  const double before = extents_[next - 1];
  return geometry::box_between(boxes_[next - 1], boxes_[next],
                               std::min((extent - before) / (extents_[next] - before), 1.0));
}

double ConfidenceFamily::extent_containing(const geometry::Box& truth, double min_iog) const {
  const auto contains_truth = [&](const Box& candidate) {
    return geometry::overlap(candidate, truth, {.measure = geometry::Overlap::kIog}) > min_iog;
  };
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (!contains_truth(boxes_[i])) continue;
    if (i == 0) return extents_[0];
    const auto between = [&](int step) {
      return step == kBetweenSteps ? extents_[i]
                                   : rounded(extents_[i - 1] + (extents_[i] - extents_[i - 1]) *
                                                                   step / kBetweenSteps);
    };
    return between(
        least_step(kBetweenSteps, [&](int step) { return contains_truth(box(between(step))); }));
  }
  if (!contains_truth(box(growth(kGrowthSteps)))) return std::numeric_limits<double>::infinity();
  return growth(
      least_step(kGrowthSteps, [&](int step) { return contains_truth(box(growth(step))); }));
}

}  // namespace arbox::evaluation
