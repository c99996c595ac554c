#include "arbox/evaluation/containment.h"

#include <string>

#include "arbox/base/error.h"
#include "arbox/geometry/overlap.h"

namespace arbox::evaluation {

std::optional<MeanOverlap> mean_overlap(std::span<const geometry::Box> predictions,
                                        std::span<const geometry::Box> truth) {
  const auto iou = geometry::overlap_pairs(predictions, truth, {});
  if (iou.size() == 0) return std::nullopt;
  const auto iog =
      geometry::overlap_pairs(predictions, truth, {.measure = geometry::Overlap::kIog});
  return MeanOverlap{.iou = iou.mean(), .iog = iog.mean()};
}

std::optional<double> contained_fraction(std::span<const geometry::Box> predictions,
                                         std::span<const geometry::Box> truth, double min_iog) {
  const auto iog =
      geometry::overlap_pairs(predictions, truth, {.measure = geometry::Overlap::kIog});
  if (iog.size() == 0) return std::nullopt;
  return static_cast<double>((iog.array() > min_iog).count()) / static_cast<double>(iog.size());
}

std::vector<ContainmentPoint> containment_curve(
    std::span<const std::vector<geometry::QuantileBox>> objects,
    std::span<const geometry::Box> truth, double min_iog) {
  if (objects.size() != truth.size()) {
    throw InvalidArgument("containment_curve: expected one true box an object, got " +
                          std::to_string(objects.size()) + " objects and " +
                          std::to_string(truth.size()) + " boxes");
  }
  std::vector<ContainmentPoint> curve;
  if (objects.empty()) return curve;
  for (std::size_t place = 0; place < objects[0].size(); ++place) {
    const double q = objects[0][place].q;
    std::vector<geometry::Box> boxes;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (objects[i].size() != objects[0].size() || objects[i][place].q != q) {
        throw InvalidArgument("containment_curve: object " + std::to_string(i) +
                              " has other quantiles than object 0");
      }
      boxes.push_back(objects[i][place].box);
    }
    curve.push_back(
        {.q = q, .promised = 1.0 - q, .contained = *contained_fraction(boxes, truth, min_iog)});
  }
  return curve;
}

}  // namespace arbox::evaluation
