#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arbox/training/adam_w.h"
#include "arbox/training/one_cycle.h"

namespace arbox::training {

/// How a network is trained.
struct TrainOptions {
  double epochs = 80;
  std::int64_t steps = 0;
  std::int64_t batch_size = 2;
  std::int64_t accumulate = 1;
  std::uint64_t seed = 0;
  OneCycleOptions schedule = {};
  AdamWOptions optimizer = {};
  double clip_norm = 10;
  double average = 0;
  std::vector<std::string> frozen = {};
  std::string initial = {};
  std::vector<std::string> initial_except = {};
  std::string best = {};
  std::int64_t max_skipped = 20;
  std::int64_t validation_interval = 0;
  std::int64_t checkpoint_interval = 0;
  double checkpoint_seconds = 300;
  double time_limit = 0;
  int threads = 0;
  int loader_threads = 1;
  double process_timeout = 300;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    constexpr double kMany = 1e15;
    visitor.field("epochs", &TrainOptions::epochs,
                  {.help = "Times that every scene is seen, unless steps are given",
                   .unit = "epochs",
                   .low = 0,
                   .high = 1e9});
    visitor.field("steps", &TrainOptions::steps,
                  {.help = "Steps of the optimiser; 0: as the epochs say",
                   .unit = "steps",
                   .low = 0,
                   .high = kMany});
    visitor.field("batch_size", &TrainOptions::batch_size,
                  {.help = "Scenes of a step, over all processes and parts",
                   .unit = "scenes",
                   .low = 1,
                   .high = 65536});
    visitor.field("accumulate", &TrainOptions::accumulate,
                  {.help = "Parts that a batch is cut into, one after the other, to save memory; "
                           "batch norms see one part at a time",
                   .low = 1,
                   .high = 65536});
    visitor.field("seed", &TrainOptions::seed,
                  {.help = "Fixes the first weights, the order of scenes and all random choices"});
    visitor.group("schedule", &TrainOptions::schedule, "Learning rate and momentum over the run");
    visitor.group("optimizer", &TrainOptions::optimizer, "AdamW");
    visitor.field("clip_norm", &TrainOptions::clip_norm,
                  {.help = "Gradients with a longer L2 norm are shortened to it; 0: never",
                   .low = 0,
                   .high = 1e12});
    visitor.field("average", &TrainOptions::average,
                  {.help = "Decay of a moving average of the weights that is validated and saved "
                           "in their place; 0: none",
                   .low = 0,
                   .high = 0.9999999});
    visitor.field("frozen", &TrainOptions::frozen,
                  {.help = "Parts that are not trained, by the beginnings of their names, for "
                           "example [backbone_3d, roi_head.shared_fc_layer]"});
    visitor.field("initial", &TrainOptions::initial,
                  {.help = "Weights to begin with: a model, a checkpoint or a weights-only file; "
                           "empty: random"});
    visitor.field(
        "initial_except", &TrainOptions::initial_except,
        {.help = "Parts that begin with random weights nevertheless, by the beginnings of "
                 "their names"});
    visitor.field("best", &TrainOptions::best,
                  {.help = "Figure of the validation whose highest value is kept as best.arbox; "
                           "empty: none"});
    visitor.field("max_skipped", &TrainOptions::max_skipped,
                  {.help = "Steps in a row that may be skipped because loss or gradient is not "
                           "finite before the run ends",
                   .unit = "steps",
                   .low = 0,
                   .high = kMany});
    visitor.field("validation_interval", &TrainOptions::validation_interval,
                  {.help = "Steps between validations; 0: only at the end",
                   .unit = "steps",
                   .low = 0,
                   .high = kMany});
    visitor.field("checkpoint_interval", &TrainOptions::checkpoint_interval,
                  {.help = "Steps between checkpoints; 0: by time only",
                   .unit = "steps",
                   .low = 0,
                   .high = kMany});
    visitor.field(
        "checkpoint_seconds", &TrainOptions::checkpoint_seconds,
        {.help = "Time between checkpoints; 0: by steps only", .unit = "s", .low = 0, .high = 1e9});
    visitor.field("time_limit", &TrainOptions::time_limit,
                  {.help = "Ends the run, or what is resumed of it, with a checkpoint after this "
                           "time, pauses not counted; 0: never",
                   .unit = "s",
                   .low = 0,
                   .high = 1e9});
    visitor.field(
        "threads", &TrainOptions::threads,
        {.help = "Threads of a step; 0: OMP_NUM_THREADS, else every core", .low = 0, .high = 1024});
    visitor.field("loader_threads", &TrainOptions::loader_threads,
                  {.help = "Threads that load or simulate scenes ahead; 0: between steps",
                   .low = 0,
                   .high = 1024});
    visitor.field("process_timeout", &TrainOptions::process_timeout,
                  {.help = "How long a process waits for the others in one sum before it gives "
                           "them up",
                   .unit = "s",
                   .low = 0.1,
                   .high = 1e6});
  }
};

/// Steps that a run over `scenes` scenes takes, at least 1. Throws ConfigError for options out of
/// range and if neither steps nor epochs are given.
std::int64_t total_steps(const TrainOptions& options, std::int64_t scenes);

/// Throws ConfigError unless a run that was begun with `begun` may go on with `options` and end
/// with the same weights: all fields are equal but the intervals, limits and threads.
void require_resumable(const TrainOptions& begun, const TrainOptions& options);

}  // namespace arbox::training
