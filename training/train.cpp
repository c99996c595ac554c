#include "arbox/training/train.h"

#include "arbox/base/error.h"
#include "arbox/training/checkpoint.h"
#include "arbox/training/internal/training_run.h"

namespace arbox::training {

void require_new_run(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw IoError(folder.string() + ": cannot be made: " + error.message());
  if (std::filesystem::exists(checkpoint_file(folder)) ||
      std::filesystem::exists(folder / "log.jsonl")) {
    throw ConfigError(folder.string() +
                      ": holds a training run; resume it, or begin in another folder");
  }
}

TrainResult train(const TrainJob& job, Communicator& processes, TrainObserver& observer) {
  return internal::TrainingRun(job, processes, observer).finish();
}

}  // namespace arbox::training
