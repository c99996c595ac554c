#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arbox/training/active_clock.h"
#include "arbox/training/adam_w.h"
#include "arbox/training/batch_sum.h"
#include "arbox/training/checkpoint.h"
#include "arbox/training/network_state.h"
#include "arbox/training/ordered_prefetch.h"
#include "arbox/training/scene_order.h"
#include "arbox/training/train.h"
#include "arbox/training/train_log.h"
#include "arbox/training/weight_average.h"

namespace arbox::training::internal {

/// One call of train().
class TrainingRun {
 public:
  TrainingRun(const TrainJob& job, Communicator& processes, TrainObserver& observer);

  TrainResult finish();

 private:
  void require_sizes() const;
  void load_or_begin();
  void restore(const Checkpoint& checkpoint);
  void share_state();
  NamedTensors state_tensors();
  void start_loading();

  TrainEnd run_steps();
  void step();
  /// Gradients and figures of the whole batch; leaves the network as it was if that fails.
  BatchFigures sum_gradients();
  BatchFigures add_gradients();
  void add_part(std::int64_t part, BatchFigures& figures);
  StepReport update(const BatchFigures& figures);
  void report_step(StepReport report, double step_seconds);

  bool validation_due() const;
  void validate();
  /// False if it was stopped.
  bool validate_alone();
  void keep_best(const ValidationReport& report);
  bool checkpoint_due();
  void save_checkpoint();
  void save_model(const std::filesystem::path& file);
  void draw();

  bool leads() const { return processes_.rank() == 0; }
  bool alone() const { return processes_.size() == 1; }
  std::filesystem::path in_folder(const char* name) const { return job_.folder / name; }
  double seconds() { return state_.seconds + clock_.seconds(); }

  const TrainJob& job_;
  const TrainOptions& options_;
  Communicator& processes_;
  TrainObserver& observer_;
  torch::nn::Module& network_;
  std::int64_t steps_;
  ActiveClock clock_;
  /// Its seconds are those of the parts of the run before this one.
  Checkpoint state_;
  std::vector<std::string> names_;
  std::unique_ptr<AdamW> optimizer_;
  std::optional<WeightAverage> average_;
  BufferBackup buffers_;
  std::optional<TrainLog> log_;
  std::unique_ptr<OrderedPrefetch<Scene>> scenes_;
  double saved_seconds_ = 0;
  double drawn_seconds_ = 0;
  double step_seconds_ = 0;
  std::vector<std::string> sources_;
  bool stopping_ = false;
  bool late_ = false;
};

}  // namespace arbox::training::internal
