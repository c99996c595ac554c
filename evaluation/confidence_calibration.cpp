#include "arbox/evaluation/confidence_calibration.h"

#include <cmath>
#include <limits>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"

namespace arbox::evaluation {
namespace {

constexpr std::int64_t kObjectsAtOnce = 16;

std::vector<double> needed_extents(std::span<const CalibrationObject> objects,
                                   const CalibrationOptions& options) {
  ConfidenceFamilyOptions family = options.family;
  family.quantile_box.threads = 1;
  std::vector<double> extents(objects.size());
  parallel_for(static_cast<std::int64_t>(objects.size()), kObjectsAtOnce, options.threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i) {
                   extents[i] = ConfidenceFamily(objects[i].samples, family)
                                    .extent_containing(objects[i].truth, options.min_iog);
                 }
               });
  return extents;
}

}  // namespace

std::int64_t ConfidenceCalibration::objects(const std::string& label) const {
  const auto place = classes.find(label);
  if (place == classes.end()) return 0;
  std::int64_t sum = 0;
  for (const ExtentCount& entry : place->second) sum += entry.count;
  return sum;
}

double ConfidenceCalibration::extent(const std::string& label, double p) const {
  std::int64_t rank = conformal_rank(objects(label), p);
  if (rank > objects(label)) return std::numeric_limits<double>::infinity();
  for (const ExtentCount& entry : classes.at(label)) {
    rank -= entry.count;
    if (rank <= 0) return entry.extent;
  }
  return std::numeric_limits<double>::infinity();
}

ConfidenceCalibration calibrate_confidence(std::span<const CalibrationObject> objects,
                                           std::string source, const CalibrationOptions& options) {
  require_valid(options.family);
  if (!(options.min_iog >= 0.0 && options.min_iog < 1.0)) {
    throw InvalidArgument("calibrate_confidence: expected min_iog in [0, 1), got " +
                          std::to_string(options.min_iog));
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    geometry::require_valid(objects[i].truth,
                            "calibrate_confidence: truth of object " + std::to_string(i));
  }
  const std::vector<double> extents = needed_extents(objects, options);
  std::map<std::string, std::map<double, std::int64_t>> counts;
  for (std::size_t i = 0; i < objects.size(); ++i) ++counts[objects[i].label][extents[i]];
  ConfidenceCalibration calibration{
      .source = std::move(source), .min_iog = options.min_iog, .family = options.family};
  for (const auto& [label, of_class] : counts) {
    for (const auto& [extent, count] : of_class) {
      calibration.classes[label].push_back({.extent = extent, .count = count});
    }
  }
  return calibration;
}

std::optional<geometry::ConfidenceBox> confidence_box(const ConfidenceCalibration& calibration,
                                                      const std::string& label,
                                                      const geometry::BoxSamples& samples,
                                                      double p) {
  const auto boxes = confidence_boxes(calibration, label, samples, {&p, 1});
  if (boxes.empty()) return std::nullopt;
  return boxes.front();
}

std::vector<geometry::ConfidenceBox> confidence_boxes(const ConfidenceCalibration& calibration,
                                                      const std::string& label,
                                                      const geometry::BoxSamples& samples,
                                                      std::span<const double> ps) {
  const ConfidenceFamily family(samples, calibration.family);
  std::vector<geometry::ConfidenceBox> boxes;
  for (const double p : ps) {
    const double extent = calibration.extent(label, p);
    if (std::isfinite(extent)) boxes.push_back({.p = p, .box = family.box(extent)});
  }
  return boxes;
}

}  // namespace arbox::evaluation
