#include <ATen/core/grad_mode.h>

#include <cmath>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/training/internal/training_run.h"

namespace arbox::training::internal {
namespace {

/// Other processes wait while the first one validates; one that ends is noticed at once.
constexpr double kLongestValidation = 7 * 24 * 3600.0;

struct ValidationStopped {};

/// Scenes of a validation that ends when the run shall end.
class StoppableScenes : public SceneSource {
 public:
  StoppableScenes(const SceneSource& scenes, TrainObserver& observer)
      : scenes_(scenes), observer_(observer) {}

  std::int64_t size() const override { return scenes_.size(); }
  Scene scene(std::int64_t index) const override {
    if (observer_.stop_requested()) throw ValidationStopped();
    return scenes_.scene(index);
  }

 private:
  const SceneSource& scenes_;
  TrainObserver& observer_;
};

/// Has the averaged weights in the network while it lives.
class AveragedWeights {
 public:
  explicit AveragedWeights(std::optional<WeightAverage>& average) : average_(average) {
    if (average_) average_->swap();
  }
  ~AveragedWeights() {
    if (average_) average_->swap();
  }
  AveragedWeights(const AveragedWeights&) = delete;
  AveragedWeights& operator=(const AveragedWeights&) = delete;

 private:
  std::optional<WeightAverage>& average_;
};

}  // namespace

bool TrainingRun::validation_due() const {
  if (job_.validation == nullptr || state_.step == 0 || state_.validated == state_.step) {
    return false;
  }
  return state_.step == steps_ ||
         (options_.validation_interval > 0 && state_.step % options_.validation_interval == 0);
}

void TrainingRun::validate() {
  bool stopped = false;
  if (leads()) stopped = !validate_alone();
  if (!alone()) processes_.wait(kLongestValidation);
  if (stopped) {
    stopping_ = alone() || state_.step == steps_;
  } else {
    state_.validated = state_.step;
  }
}

bool TrainingRun::validate_alone() {
  const double began = clock_.seconds();
  ValidationReport report{.step = state_.step, .figures = {}, .seconds = 0};
  try {
    const at::NoGradGuard no_gradient;
    const AveragedWeights averaged(average_);
    network_.eval();
    report.figures = job_.trainee.evaluate(StoppableScenes(*job_.validation, observer_));
    keep_best(report);
  } catch (const ValidationStopped&) {
    set_training(network_, options_.frozen);
    return false;
  }
  set_training(network_, options_.frozen);
  report.seconds = clock_.seconds() - began;
  log_->write(report);
  observer_.on_validation(report);
  draw();
  return true;
}

void TrainingRun::keep_best(const ValidationReport& report) {
  if (options_.best.empty()) return;
  const auto figure = report.figures.find(options_.best);
  if (figure == report.figures.end()) {
    std::vector<std::string> names;
    for (const auto& [name, ignored] : report.figures) names.push_back(name);
    throw ConfigError("train.best: " + unknown_name_text("figure", options_.best, names));
  }
  const double value = figure->second;
  if (std::isnan(value) || (state_.best_step >= 0 && value <= state_.best)) return;
  state_.best = value;
  state_.best_step = state_.step;
  job_.trainee.save(in_folder("best.arbox"));
}

void TrainingRun::save_model(const std::filesystem::path& file) {
  const at::NoGradGuard no_gradient;
  const AveragedWeights averaged(average_);
  network_.eval();
  job_.trainee.save(file);
  set_training(network_, options_.frozen);
}

}  // namespace arbox::training::internal
