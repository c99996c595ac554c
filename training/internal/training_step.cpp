#include <ATen/Context.h>
#include <ATen/TensorOperators.h>
#include <torch/csrc/autograd/autograd.h>

#include <array>
#include <cmath>
#include <mutex>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/random.h"
#include "arbox/sparse/shared_statistics.h"
#include "arbox/training/internal/training_run.h"
#include "arbox/training/one_cycle.h"

namespace arbox::training::internal {
namespace {

constexpr std::uint32_t kPurpose = 0x57e9;
constexpr double kPictureSeconds = 20;

/// For layers such as dropout, which draw from LibTorch's generator: what a part of a step draws
/// depends on nothing that was drawn before.
void seed_torch(std::uint64_t seed, std::int64_t part, int process) {
  const auto words = RandomStream(seed, static_cast<std::uint64_t>(part), kPurpose)
                         .words(static_cast<std::uint32_t>(process));
  at::manual_seed(std::uint64_t{words[0]} << 32 | words[1]);
}

/// A SceneOrder for several threads.
class SharedOrder {
 public:
  SharedOrder(std::uint64_t seed, std::int64_t scenes) : order_(seed, scenes) {}

  std::int64_t at(std::int64_t place) {
    const std::scoped_lock lock(mutex_);
    return order_.at(place);
  }

 private:
  std::mutex mutex_;
  SceneOrder order_;
};

}  // namespace

void TrainingRun::start_loading() {
  const std::int64_t part_size = options_.batch_size / options_.accumulate;
  const auto share = [part_size, rank = processes_.rank(), size = processes_.size()](auto batch) {
    return batch_share(batch, part_size, rank, size);
  };
  const std::int64_t count = share(0).count;
  const auto order = std::make_shared<SharedOrder>(options_.seed, job_.training.size());
  const auto load = [this, share, count, order](std::int64_t number) {
    const std::int64_t place = share(number / count).first + number % count;
    Scene scene = job_.training.scene(order->at(place));
    job_.trainee.prepare(scene, options_.seed, place);
    return scene;
  };
  const std::int64_t a_step = options_.accumulate * count;
  scenes_ = std::make_unique<OrderedPrefetch<Scene>>(load, state_.step * a_step, steps_ * a_step,
                                                     options_.loader_threads,
                                                     2 * count + options_.loader_threads);
}

TrainEnd TrainingRun::run_steps() {
  while (true) {
    if (validation_due()) validate();
    if (state_.step == steps_ && !validation_due()) return TrainEnd::kFinished;
    if (stopping_ || (alone() && observer_.stop_requested())) return TrainEnd::kStopped;
    if (late_) return TrainEnd::kTimeLimit;
    step();
    if (checkpoint_due()) {
      save_checkpoint();
      if (seconds() - drawn_seconds_ >= kPictureSeconds) draw();
    }
  }
}

void TrainingRun::step() {
  const double began = clock_.seconds();
  const BatchFigures figures = sum_gradients();
  stopping_ = figures.stops > 0;
  late_ = figures.late > 0;
  StepReport report = update(figures);
  optimizer_->clear_gradients();
  report_step(std::move(report), clock_.seconds() - began);
  if (state_.skipped_in_row > options_.max_skipped) {
    throw NumericalError("train: the loss or its gradient was not finite in " +
                         std::to_string(state_.skipped_in_row) +
                         " steps in a row; the last scenes: " + join(sources_, ", "));
  }
}

BatchFigures TrainingRun::sum_gradients() {
  buffers_.save();
  try {
    BatchFigures figures = add_gradients();
    figures.stops = observer_.stop_requested() ? 1 : 0;
    figures.late = options_.time_limit > 0 && clock_.seconds() >= options_.time_limit ? 1 : 0;
    sum_batch(optimizer_->parameters(), figures, processes_);
    return figures;
  } catch (const std::exception&) {
    buffers_.restore();
    throw;
  }
}

BatchFigures TrainingRun::add_gradients() {
  BatchFigures figures;
  sources_.clear();
  std::optional<sparse::SharedStatistics> shared;
  if (!alone()) shared.emplace([this](at::Tensor& numbers) { processes_.sum(numbers); });
  for (std::int64_t part = 0; part < options_.accumulate; ++part) add_part(part, figures);
  return figures;
}

void TrainingRun::add_part(std::int64_t part, BatchFigures& figures) {
  const std::int64_t number = state_.step * options_.accumulate + part;
  const BatchShare share = batch_share(number, options_.batch_size / options_.accumulate,
                                       processes_.rank(), processes_.size());
  std::vector<Scene> scenes;
  for (std::int64_t i = 0; i < share.count; ++i) {
    scenes.push_back(scenes_->next());
    sources_.push_back(scenes.back().source);
  }
  seed_torch(options_.seed, number, processes_.rank());
  const double weight = 1.0 / static_cast<double>(options_.accumulate);
  try {
    const StepLoss loss =
        job_.trainee.loss(scenes, {number, options_.seed, share.first}, processes_);
    figures.loss += loss.total.item<double>() * weight;
    for (const auto& [name, value] : loss.terms) figures.terms[name] += value * weight;
    if (loss.total.requires_grad()) torch::autograd::backward({loss.total * weight}, {});
  } catch (const NumericalError&) {
    if (!alone()) throw;
    figures.loss = std::nan("");
  }
}

StepReport TrainingRun::update(const BatchFigures& figures) {
  const CyclePoint point = one_cycle(options_.schedule, state_.step, steps_);
  const double norm = optimizer_->gradient_norm();
  const bool skipped = !std::isfinite(figures.loss) || !std::isfinite(norm);
  if (skipped) {
    buffers_.restore();
    ++state_.skipped;
    ++state_.skipped_in_row;
  } else {
    const bool clipped = options_.clip_norm > 0 && norm > options_.clip_norm;
    optimizer_->step(point, clipped ? options_.clip_norm / norm : 1.0);
    if (average_) average_->update(optimizer_->steps());
    state_.skipped_in_row = 0;
  }
  ++state_.step;
  StepReport report;
  report.loss = figures.loss;
  report.terms = figures.terms;
  report.learning_rate = point.learning_rate;
  report.momentum = point.momentum;
  report.gradient_norm = norm;
  report.skipped = skipped;
  return report;
}

void TrainingRun::report_step(StepReport report, double step_seconds) {
  constexpr double kNew = 0.1;
  step_seconds_ =
      step_seconds_ > 0 ? step_seconds_ + kNew * (step_seconds - step_seconds_) : step_seconds;
  const auto scenes = static_cast<double>(options_.batch_size);
  report.step = state_.step;
  report.steps = steps_;
  report.epoch = static_cast<double>(state_.step) * scenes / static_cast<double>(state_.scenes);
  report.seconds = seconds();
  report.scenes_per_second = scenes / std::max(step_seconds, 1e-9);
  report.seconds_left = step_seconds_ * static_cast<double>(steps_ - state_.step);
  if (log_) log_->write(report);
  observer_.on_step(report);
}

}  // namespace arbox::training::internal
