#pragma once

#include <chrono>
#include <string>

#include "arbox/training/train_report.h"

namespace arbox::cli {

/// Tells on standard error how a training run goes: on a terminal one line that is drawn anew, else
/// a line every ten seconds; a line for each validation.
class TrainingProgress : public training::TrainObserver {
 public:
  /// `descriptor` is where it writes.
  explicit TrainingProgress(int descriptor = 2);
  ~TrainingProgress() override;
  TrainingProgress(const TrainingProgress&) = delete;
  TrainingProgress& operator=(const TrainingProgress&) = delete;

  void on_step(const training::StepReport& report) override;
  void on_validation(const training::ValidationReport& report) override;

 private:
  using Clock = std::chrono::steady_clock;

  void write(const std::string& text) const;
  std::string erase() const;

  int descriptor_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point next_;
};

/// "step 120/4000, 1:02:03 left, loss 1.32 (box 0.4, class 0.92), epoch 0.48, rate 0.0012, 2.1
/// scenes/s".
std::string training_text(const training::StepReport& report);
/// "validation after step 120: Car 0.51, Pedestrian 0.3".
std::string training_text(const training::ValidationReport& report);

}  // namespace arbox::cli
