#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/evaluation/confidence_family.h"
#include "arbox/evaluation/conformal.h"

/// \file
/// Confidence boxes that keep their promise: for each class, the extents (confidence_family.h) that
/// objects with known truth needed, and from these the extent that contains a new object with
/// probability p (evaluation/conformal.h).
///
///     const auto calibration = calibrate_confidence(objects, "KITTI val, 3769 frames", options);
///     const auto box = confidence_box(calibration, "Car", samples, 0.9);
///
/// The promise holds for objects that are exchangeable with those of the calibration: found by the
/// same detector in scans of the same kind, and matched to their truth in the same way. It says
/// nothing of objects that are not found. Calibrate on scans that the detector was not trained on.

namespace arbox::evaluation {

/// A detected object whose true box is known.
struct CalibrationObject {
  std::string label;
  geometry::BoxSamples samples;
  geometry::Box truth;
};

struct CalibrationOptions {
  ConfidenceFamilyOptions family = {};
  /// The share of the true box that counts as containing it.
  double min_iog = kContainedIog;
  /// 0 means default_threads(). The result does not depend on it.
  int threads = 0;
};

/// How many objects of a class needed an extent; infinity where none was large enough.
struct ExtentCount {
  double extent = 0.0;
  std::int64_t count = 0;
};

struct ConfidenceCalibration {
  /// What it was calibrated on, for people.
  std::string source;
  double min_iog = kContainedIog;
  ConfidenceFamilyOptions family = {};
  /// By class: extents rising, each once, counts above 0.
  std::map<std::string, std::vector<ExtentCount>> classes = {};

  /// Objects of a class; 0 for one that was not calibrated.
  std::int64_t objects(const std::string& label) const;
  /// The extent that promises p; infinity where the class has too few objects
  /// (conformal_objects_needed) or too many that nothing contained. Throws InvalidArgument unless
  /// 0 < p < 1.
  double extent(const std::string& label, double p) const;
};

/// Collects the extents that the objects needed. No objects give a calibration without classes.
/// Throws InvalidArgument for bad samples, truth (naming the object) or options. Cost: the quantile
/// boxes of every object.
ConfidenceCalibration calibrate_confidence(std::span<const CalibrationObject> objects,
                                           std::string source,
                                           const CalibrationOptions& options = {});

/// The box that contains an object of that class with probability p; empty where the calibration
/// cannot promise p. Throws as ConfidenceFamily and ConfidenceCalibration::extent do.
std::optional<geometry::ConfidenceBox> confidence_box(const ConfidenceCalibration& calibration,
                                                      const std::string& label,
                                                      const geometry::BoxSamples& samples,
                                                      double p);

/// Those for several p, in the order asked for and nested where p rises; a p that cannot be
/// promised is left out. The family is made once.
std::vector<geometry::ConfidenceBox> confidence_boxes(const ConfidenceCalibration& calibration,
                                                      const std::string& label,
                                                      const geometry::BoxSamples& samples,
                                                      std::span<const double> ps);

/// The calibration as JSON text that reads back as the same:
///
///     {"format": "arbox confidence calibration", "version": 1, "source": "...", "min_iog": 0.95,
///      "quantiles": [0.95, ..., 0], "quantile_box": {"points_per_box": 64, ...},
///      "classes": {"Car": {"extents": [[0.05, 3], [0.1, 7], ...], "uncontained": 2}}}
std::string to_json(const ConfidenceCalibration& calibration);

/// Reads such a text. Throws FormatError that names `source` and the place in it.
ConfidenceCalibration parse_confidence_calibration(std::string_view text, std::string_view source);

}  // namespace arbox::evaluation
