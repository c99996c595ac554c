#include "arbox/training/internal/training_run.h"

#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/tensor.h>

#include <exception>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/drawing/image.h"
#include "arbox/training/durable_file.h"
#include "arbox/training/train_figure.h"
#include "arbox/training/weights_file.h"

namespace arbox::training::internal {
namespace {

std::vector<at::Tensor> tensors_of(const std::vector<std::pair<std::string, at::Tensor>>& named) {
  std::vector<at::Tensor> tensors;
  for (const auto& [name, tensor] : named) tensors.push_back(tensor);
  return tensors;
}

std::vector<at::Tensor> tensors_of(const NamedTensors& named) {
  std::vector<at::Tensor> tensors;
  for (const auto& [name, tensor] : named) tensors.push_back(tensor);
  return tensors;
}

void use_threads(int threads) {
  if (threads > 0) set_default_threads(threads);
  at::set_num_threads(default_threads());
  at::globalContext().setDeterministicAlgorithms(true, true);
}

}  // namespace

TrainingRun::TrainingRun(const TrainJob& job, Communicator& processes, TrainObserver& observer)
    : job_(job),
      options_(job.options),
      processes_(processes),
      observer_(observer),
      network_(job.trainee.network()),
      steps_(total_steps(job.options, job.training.size())),
      buffers_(network_) {
  require_sizes();
  use_threads(options_.threads);
  set_training(network_, options_.frozen);
  const auto trained = trained_parameters(network_);
  if (trained.empty()) throw ConfigError("frozen: no part of the network is left to be trained");
  for (const auto& [name, ignored] : trained) names_.push_back(name);
  optimizer_ = std::make_unique<AdamW>(tensors_of(trained), options_.optimizer);
  state_.options = options_;
  state_.scenes = job_.training.size();
}

void TrainingRun::require_sizes() const {
  if (job_.training.size() < 1) throw ConfigError("train: the training data hold no scenes");
  const std::int64_t parts = options_.accumulate * processes_.size();
  if (options_.batch_size % options_.accumulate != 0 || options_.batch_size < parts) {
    throw ConfigError(
        "train: expected a batch_size that accumulate divides and that gives each of " +
        std::to_string(processes_.size()) + " processes a scene, got batch_size " +
        std::to_string(options_.batch_size) + " and accumulate " +
        std::to_string(options_.accumulate));
  }
}

TrainResult TrainingRun::finish() {
  if (leads()) load_or_begin();
  share_state();
  if (leads()) log_.emplace(in_folder("log.jsonl"), state_.step, state_.validated);
  saved_seconds_ = seconds();
  start_loading();
  TrainEnd end = TrainEnd::kFinished;
  try {
    end = run_steps();
  } catch (const std::exception&) {
    const auto failure = std::current_exception();
    try {
      save_checkpoint();
    } catch (const std::exception&) {
      // The first failure says more than that its checkpoint failed, too.
    }
    std::rethrow_exception(failure);
  }
  if (leads()) {
    save_checkpoint();
    draw();
    if (end == TrainEnd::kFinished) save_model(in_folder("model.arbox"));
  }
  return {end, state_.step, state_.skipped};
}

void TrainingRun::load_or_begin() {
  const std::filesystem::path file = checkpoint_file(job_.folder);
  std::error_code error;
  if (job_.resume) {
    std::filesystem::create_directories(job_.folder, error);
  } else {
    require_new_run(job_.folder);
  }
  remove_unfinished(job_.folder);
  if (std::filesystem::exists(file)) {
    restore(read_checkpoint(file));
  } else if (!options_.initial.empty()) {
    load_weights(network_, options_.initial, options_.initial_except);
  }
}

void TrainingRun::restore(const Checkpoint& checkpoint) {
  require_resumable(checkpoint.options, options_);
  if (checkpoint.scenes != state_.scenes) {
    throw ConfigError("resume: the run was begun with " + std::to_string(checkpoint.scenes) +
                      " scenes, the training data now hold " + std::to_string(state_.scenes));
  }
  if (options_.average > 0) average_.emplace(optimizer_->parameters(), options_.average);
  copy_tensors(state_tensors(), checkpoint.tensors, checkpoint_file(job_.folder).string());
  state_ = checkpoint;
  state_.options = options_;
  state_.tensors.clear();
}

void TrainingRun::share_state() {
  const auto number = [](auto value) { return static_cast<double>(value); };
  at::Tensor numbers = at::tensor(
      {number(state_.step), number(state_.validated), number(state_.skipped),
       number(state_.skipped_in_row), state_.seconds, state_.best, number(state_.best_step)},
      at::kDouble);
  share_from_first({numbers}, processes_);
  const auto* values = numbers.data_ptr<double>();
  state_.step = static_cast<std::int64_t>(values[0]);
  state_.validated = static_cast<std::int64_t>(values[1]);
  state_.skipped = static_cast<std::int64_t>(values[2]);
  state_.skipped_in_row = static_cast<std::int64_t>(values[3]);
  state_.seconds = values[4];
  state_.best = values[5];
  state_.best_step = static_cast<std::int64_t>(values[6]);
  if (options_.average > 0 && !average_) {
    average_.emplace(optimizer_->parameters(), options_.average);
  }
  share_from_first(tensors_of(state_tensors()), processes_);
  optimizer_->set_steps(state_.step - state_.skipped);
  buffers_.save();
}

NamedTensors TrainingRun::state_tensors() {
  NamedTensors tensors;
  for (const auto& [name, tensor] : network_tensors(network_)) tensors["network/" + name] = tensor;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    tensors["first_moment/" + names_[i]] = optimizer_->first_moments()[i];
    tensors["second_moment/" + names_[i]] = optimizer_->second_moments()[i];
    if (average_) tensors["average/" + names_[i]] = average_->values()[i];
  }
  return tensors;
}

bool TrainingRun::checkpoint_due() {
  if (!leads() || state_.step == steps_) return false;
  const bool by_steps =
      options_.checkpoint_interval > 0 && state_.step % options_.checkpoint_interval == 0;
  return by_steps || (options_.checkpoint_seconds > 0 &&
                      seconds() - saved_seconds_ >= options_.checkpoint_seconds);
}

void TrainingRun::save_checkpoint() {
  // Helping processes have no files, unless they are what is left of a run.
  std::error_code error;
  std::filesystem::create_directories(job_.folder, error);
  Checkpoint checkpoint = state_;
  checkpoint.seconds = seconds();
  checkpoint.tensors = state_tensors();
  const std::filesystem::path file = checkpoint_file(job_.folder);
  write_checkpoint(file, checkpoint);
  saved_seconds_ = seconds();
  observer_.on_checkpoint(file, state_.step);
}

void TrainingRun::draw() {
  if (log_->history().steps.empty()) return;
  drawn_seconds_ = seconds();
  drawing::write_image(draw_training(log_->history()), in_folder("losses.png"));
}

}  // namespace arbox::training::internal
