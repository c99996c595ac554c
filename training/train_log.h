#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "arbox/training/train_report.h"

namespace arbox::training {

/// What a log says.
struct TrainHistory {
  std::vector<StepReport> steps;
  std::vector<ValidationReport> validations;
};

/// A file of one JSON object a line: {"step": 12, "loss": 0.7, "terms": {...}, ...} for a step,
/// {"validation": 12, "figures": {...}, ...} for a validation. Numbers that are not finite are
/// null.
class TrainLog {
 public:
  /// Opens the log of a run that stands at `step` with validation `validated`: what a killed run
  /// wrote later, and half a line at the end, is cut off. -1 for none. Throws IoError.
  TrainLog(std::filesystem::path file, std::int64_t step, std::int64_t validated);

  /// Appends a line, which is in the file when this returns. Throws IoError.
  void write(const StepReport& report);
  void write(const ValidationReport& report);

  /// The log from the beginning of the run.
  const TrainHistory& history() const { return history_; }

 private:
  void append(const std::string& line);

  std::filesystem::path file_;
  TrainHistory history_;
};

/// Reads a log, leaving out lines that are no JSON. Throws IoError.
TrainHistory read_train_log(const std::filesystem::path& file);

}  // namespace arbox::training
