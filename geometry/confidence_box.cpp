#include "arbox/geometry/confidence_box.h"

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/geometry/enclosing_box.h"
#include "arbox/geometry/internal/sample_set.h"
#include "arbox/geometry/overlap.h"

namespace arbox::geometry {

using internal::require_valid;

namespace {

constexpr int kLevels = 64;
constexpr double kRounding = 1e-12;
/// Halvings of the way from a box that holds too little to one that holds enough.
constexpr int kHalvings = 8;

/// Falling to 0.
std::vector<double> levels() {
  std::vector<double> qs;
  for (int level = kLevels - 1; level >= 0; --level) {
    qs.push_back(static_cast<double>(level) / kLevels);
  }
  return qs;
}

/// Shares that are asked for when they are needed.
class HeldShares {
 public:
  HeldShares(const BoxSamples& samples, const std::vector<QuantileBox>& boxes)
      : samples_(samples), boxes_(boxes), shares_(boxes.size(), -1.0) {}

  double of(std::size_t i) {
    if (shares_[i] < 0.0) shares_[i] = held_share(samples_, boxes_[i].box);
    return shares_[i];
  }

 private:
  const BoxSamples& samples_;
  const std::vector<QuantileBox>& boxes_;
  std::vector<double> shares_;
};

/// The part of the samples' weight whose overlap with the box passes.
template <class Passes>
double share_that(const BoxSamples& samples, const Box& box, Overlap measure,
                  const Passes& passes) {
  const auto overlaps =
      overlap_matrix(std::span(&box, 1), samples.boxes, {.measure = measure, .threads = 1});
  double passing = 0.0, all = 0.0;
  for (std::size_t i = 0; i < samples.boxes.size(); ++i) {
    const double weight = samples.weights.empty() ? 1.0 : samples.weights[i];
    all += weight;
    if (passes(overlaps(0, static_cast<Eigen::Index>(i)))) passing += weight;
  }
  return passing / all;
}

void require_probabilities(std::span<const double> ps) {
  for (const double p : ps) {
    if (p >= 0.0 && p <= 1.0) continue;
    throw InvalidArgument("confidence_boxes: expected probabilities from 0 to 1, got " +
                          std::to_string(p));
  }
}

/// The least box between one that holds less than p and one that holds p or more.
Box least_between(const BoxSamples& samples, const Box& less, const Box& enough, double p) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    const bool holds = held_share(samples, box_between(less, enough, middle)) >= p - kRounding;
    (holds ? high : low) = middle;
  }
  return box_between(less, enough, high);
}

std::vector<ConfidenceBox> boxes_of(const BoxSamples& samples, std::span<const double> ps,
                                    const std::vector<QuantileBox>& boxes) {
  HeldShares shares(samples, boxes);
  std::vector<ConfidenceBox> result;
  for (const double p : ps) {
    std::size_t i = 0;
    while (i + 1 < boxes.size() && shares.of(i) < p - kRounding) ++i;
    const Box& box = boxes[i].box;
    result.push_back(
        {.p = p, .box = i > 0 ? least_between(samples, boxes[i - 1].box, box, p) : box});
  }
  return result;
}

}  // namespace

double held_share(const BoxSamples& samples, const Box& box, double min_iog) {
  require_valid(samples, "held_share");
  return share_that(samples, box, Overlap::kIog, [&](double covered) { return covered > min_iog; });
}

double overlapping_share(const BoxSamples& samples, const Box& box, double min_iou) {
  require_valid(samples, "overlapping_share");
  return share_that(samples, box, Overlap::kIou, [&](double iou) { return iou >= min_iou; });
}

std::vector<std::vector<ConfidenceBox>> confidence_boxes(std::span<const BoxSamples> objects,
                                                         std::span<const double> ps,
                                                         const QuantileOptions& options) {
  require_probabilities(ps);
  std::vector<std::vector<ConfidenceBox>> result(objects.size());
  if (ps.empty()) return result;
  const auto boxes = quantile_boxes(objects, levels(), options);
  parallel_for(std::ssize(objects), 1, options.threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) result[i] = boxes_of(objects[i], ps, boxes[i]);
  });
  return result;
}

std::vector<ConfidenceBox> confidence_boxes(const BoxSamples& samples, std::span<const double> ps,
                                            const QuantileOptions& options) {
  return confidence_boxes(std::span(&samples, 1), ps, options).front();
}

}  // namespace arbox::geometry
