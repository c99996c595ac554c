#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arbox/cli/uncertainty_figure.h"
#include "arbox/evaluation/kitti_protocol.h"
#include "arbox/evaluation/recall.h"
#include "arbox/evaluation/uncertainty_protocol.h"

namespace arbox::cli {

/// What `arbox benchmark` compares on labelled scans in KITTI's layout.
struct OutdoorBenchmarkOptions {
  std::filesystem::path data;
  std::string split = "val";
  /// Scans at most; 0 for all.
  std::int64_t scans = 0;
  /// There are labels of what the camera does not see (label_360): promises and uncertainty are
  /// scored in all directions. Average precision and recall are always those of the camera's view,
  /// where those objects are then neither for nor against a detector.
  bool all_round = false;
  /// A model file or name; empty for none.
  std::string model;
  /// Heads of the model; empty for all.
  std::vector<std::string> heads;
  bool cluster_fit = true;
  std::vector<double> quantiles = {0.1, 0.2, 0.4, 0.5};
  /// Confidence boxes at these p, from the model's first head, which must be calibrated.
  std::vector<double> confidences = {};
  /// Least score of what counts for average precision, and for promises and uncertainty.
  double score = 0.1, found_score = 0.3;
  /// Scans that each row is timed on, alone.
  std::int64_t timed = 20;
};

/// How one kind of box of one detector did.
struct BenchmarkRow {
  /// cluster_fit, pointwise, or the name of a head; and beam, mean, box, or "q 0.2".
  std::string detector, box;
  evaluation::KittiReport iou, iog;
  evaluation::RecallReport recall;
  /// Of detect() from the points to the boxes; empty for rows that are not timed.
  std::optional<double> median_milliseconds, slow_milliseconds;
};

struct OutdoorBenchmark {
  OutdoorBenchmarkOptions options;
  std::string title;
  std::size_t scans = 0;
  std::vector<BenchmarkRow> rows;
  /// By detector, and kGaussianDeviation.
  std::vector<NamedUncertainty> uncertainty;
  int threads = 0;
  /// The program's largest resident memory, megabytes.
  double peak_memory = 0.0;
};

/// Runs all detectors on all scans. Throws UsageError if there is nothing to compare; what reading,
/// models and detectors throw.
OutdoorBenchmark run_outdoor_benchmark(const OutdoorBenchmarkOptions& options);

/// docs/formats.md, "The outdoor benchmark as JSON".
std::string to_json(const OutdoorBenchmark& benchmark);
/// Tables in Markdown: IoU, IoG, promises and uncertainty, speed.
std::string to_markdown(const OutdoorBenchmark& benchmark);

/// Average precision of cars (moderate), IoU beside IoG: a panel for each head, with the pointwise
/// boxes first, and one for cluster_fit.
drawing::Image draw_average_precision(const OutdoorBenchmark& benchmark);

}  // namespace arbox::cli
