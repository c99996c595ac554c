#include "arbox/cli/torch_training.h"

#include "arbox/base/options.h"
#include "arbox/training/gloo_communicator.h"
#include "arbox/training/pv_rcnn_training.h"
#include "arbox/training/stop_signals.h"

namespace arbox::cli {
namespace {

/// Hands on what the program's observer is told, and ends the run on signals.
class SignalledObserver : public training::TrainObserver {
 public:
  explicit SignalledObserver(training::TrainObserver* observer) : observer_(*observer) {}

  void on_step(const training::StepReport& report) override { observer_.on_step(report); }
  void on_validation(const training::ValidationReport& report) override {
    observer_.on_validation(report);
  }
  void on_checkpoint(const std::filesystem::path& file, std::int64_t step) override {
    observer_.on_checkpoint(file, step);
  }
  bool stop_requested() override {
    return training::StopSignals::received() != 0 || observer_.stop_requested();
  }

 private:
  training::TrainObserver& observer_;
  training::StopSignals signals_;
};

}  // namespace

OptionsInstance make_training_options() { return make_options<training::PvRcnnTraining>(); }

TrainOutcome train(const TrainRequest& request) {
  const training::PvRcnnTraining configuration =
      training::read_pv_rcnn_training(request.configuration, request.overrides);
  const auto processes = training::make_communicator(training::ProcessGroup::from_environment(),
                                                     configuration.train.process_timeout);
  SignalledObserver observer(request.observer);
  const training::TrainResult result =
      training::train_pv_rcnn(configuration, request.folder, request.resume, *processes, observer);
  return {.leads = processes->rank() == 0,
          .finished = result.end == training::TrainEnd::kFinished,
          .steps = result.steps,
          .skipped = result.skipped};
}

}  // namespace arbox::cli
