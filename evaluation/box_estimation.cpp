#include "arbox/evaluation/box_estimation.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/geometry/overlap.h"

namespace arbox::evaluation {
namespace {

using geometry::Box;

double f1(double iou, double iog) { return iou + iog > 0.0 ? 2.0 * iou * iog / (iou + iog) : 0.0; }

// Sorted sizes give the least sum of differences over all orders.
double dimension_error(Eigen::Vector3d first, Eigen::Vector3d second) {
  std::sort(first.data(), first.data() + 3);
  std::sort(second.data(), second.data() + 3);
  return (first - second).cwiseAbs().sum();
}

}  // namespace

BoxError box_error(const Box& predicted, const Box& truth, geometry::BoxSymmetry symmetry) {
  const double intersection =
      geometry::overlap(predicted, truth, {.measure = geometry::Overlap::kIntersection});
  const double truth_volume = geometry::volume(truth);
  const double all = geometry::volume(predicted) + truth_volume - intersection;
  BoxError error;
  error.iou = std::clamp(intersection / all, 0.0, 1.0);
  error.iog = std::clamp(intersection / truth_volume, 0.0, 1.0);
  error.f1 = f1(error.iou, error.iog);
  error.dimensions = dimension_error(predicted.size, truth.size);
  error.quaternion = geometry::rotation_distance(predicted.rotation, truth.rotation, symmetry);
  error.center = (predicted.center - truth.center).norm();
  return error;
}

BoxEstimationReport evaluate_boxes(std::span<const Box> predicted, std::span<const Box> truth,
                                   const BoxEstimationOptions& options) {
  if (predicted.size() != truth.size()) {
    throw InvalidArgument("evaluate_boxes: expected one prediction a true box (" +
                          std::to_string(truth.size()) + "), got " +
                          std::to_string(predicted.size()));
  }
  geometry::require_valid(predicted, "evaluate_boxes: predictions");
  geometry::require_valid(truth, "evaluate_boxes: truth");
  constexpr std::int64_t kGrain = 256;
  std::vector<BoxError> errors(truth.size());
  parallel_for(static_cast<std::int64_t>(truth.size()), kGrain, options.threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   const auto at = static_cast<std::size_t>(i);
                   errors[at] = box_error(predicted[at], truth[at], options.symmetry);
                 }
               });
  BoxEstimationReport report;
  report.objects = truth.size();
  if (truth.empty()) return report;
  const auto count = static_cast<double>(truth.size());
  for (const BoxError& error : errors) {
    report.mean.iou += error.iou / count;
    report.mean.iog += error.iog / count;
    report.mean.f1 += error.f1 / count;
    report.mean.dimensions += error.dimensions / count;
    report.mean.quaternion += error.quaternion / count;
    report.mean.center += error.center / count;
    report.contained += error.iog > options.min_iog ? 1.0 / count : 0.0;
  }
  report.f1_of_means = f1(report.mean.iou, report.mean.iog);
  return report;
}

std::string to_json(const BoxEstimationReport& report) {
  const nlohmann::ordered_json json = {{"protocol", "boxes"},
                                       {"objects", report.objects},
                                       {"mean_iou", report.mean.iou},
                                       {"mean_iog", report.mean.iog},
                                       {"f1_of_means", report.f1_of_means},
                                       {"mean_f1", report.mean.f1},
                                       {"err_dim", report.mean.dimensions},
                                       {"err_quat", report.mean.quaternion},
                                       {"err_center", report.mean.center},
                                       {"contained", report.contained}};
  return json.dump(2) + "\n";
}

std::string to_table(const BoxEstimationReport& report) {
  char text[512];
  const int size = std::snprintf(
      text, sizeof text,
      "objects      %zu\nmean IoU     %.4f\nmean IoG     %.4f\nF1 of means  %.4f\n"
      "mean F1      %.4f\nerr_dim      %.4f m\nerr_quat     %.4f rad\nerr_center   %.4f m\n"
      "contained    %.4f\n",
      report.objects, report.mean.iou, report.mean.iog, report.f1_of_means, report.mean.f1,
      report.mean.dimensions, report.mean.quaternion, report.mean.center, report.contained);
  return {text, static_cast<std::size_t>(size)};
}

}  // namespace arbox::evaluation
