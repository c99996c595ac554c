#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace arbox::training {

/// What is told of a step after it was done.
struct StepReport {
  /// Steps done, of how many.
  std::int64_t step = 0, steps = 0;
  /// Epochs done.
  double epoch = 0;
  /// Loss of the whole batch and its terms.
  double loss = 0;
  std::map<std::string, double> terms;
  double learning_rate = 0, momentum = 0;
  /// Before clipping.
  double gradient_norm = 0;
  /// True if the weights were left alone because loss or gradient is not finite.
  bool skipped = false;
  /// Time since the run began, without pauses, all resumed parts added up.
  double seconds = 0;
  double scenes_per_second = 0;
  /// Expected time to the last step, validation not counted.
  double seconds_left = 0;
};

struct ValidationReport {
  std::int64_t step = 0;
  std::map<std::string, double> figures;
  double seconds = 0;
};

/// Is told how a run goes, and may end it. Called on the thread of train().
class TrainObserver {
 public:
  virtual ~TrainObserver() = default;
  virtual void on_step(const StepReport& /*report*/) {}
  virtual void on_validation(const ValidationReport& /*report*/) {}
  virtual void on_checkpoint(const std::filesystem::path& /*file*/, std::int64_t /*step*/) {}
  /// Asked after every step and between scenes of a validation, from any thread: true ends the run
  /// with a checkpoint.
  virtual bool stop_requested() { return false; }
};

}  // namespace arbox::training
