#pragma once

#include <CLI/App.hpp>
#include <memory>
#include <string>
#include <vector>

#include "arbox/detectors/detector.h"
#include "arbox/io/known_sizes.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {

/// What every command that detects lets its user choose: the detector, what it is asked for, and
/// how clouds are read.
struct DetectorFlags {
  /// By name; empty for a model, or what is there if that is empty, too: the shipped model, else
  /// cluster_fit.
  std::string detector;
  /// A trained detector: a model file or the name of one, and which of its heads and boxes answer.
  std::string model, head, mode;
  std::string config;
  std::vector<std::string> overrides;
  detectors::DetectionRequest request{.score = 0.3};
  /// Where request.known_sizes come from.
  std::string known_sizes_file;
  io::KnownSizeTable known_sizes;
  io::ReadOptions read;
};

/// Adds --model, --head, --mode, --detector, --config, --set, --quantile, --confidence, --score,
/// --known-sizes, --seed, --samples, --channels and --input-format. `flags` must outlive the
/// parsing and stay where it is. Parsing throws as io::read_known_sizes.
void add_detector_flags(CLI::App& command, DetectorFlags& flags);

/// The detector that was chosen. Throws UsageError for a name that nobody knows, --head, --set, and
/// --known-sizes with a detector that cannot use them; PluginError, ConfigError, FormatError,
/// IoError.
std::unique_ptr<detectors::Detector> make_detector(const DetectorFlags& flags);

}  // namespace arbox::cli
