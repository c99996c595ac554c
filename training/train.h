#pragma once

#include <cstdint>
#include <filesystem>

#include "arbox/training/communicator.h"
#include "arbox/training/scene.h"
#include "arbox/training/train_options.h"
#include "arbox/training/train_report.h"
#include "arbox/training/trainee.h"

/// \file
/// Trains a network on scenes. A run lives in a folder:
///
///     log.jsonl          a line for each step and validation (train_log.h)
///     losses.png         its course, drawn at validations and at the end (train_figure.h)
///     checkpoint.arbox   where the run stands (checkpoint.h)
///     best.arbox         the model with the best validation, if TrainOptions::best names a figure
///     model.arbox        the trained model, once the run is finished
///
/// Equal networks, sources, options, threads and processes give equal weights to the last bit,
/// however often the run was ended and resumed. With several processes (gloo_communicator.h) each
/// works on its share of every batch; process 0 writes the files and validates.

namespace arbox::training {

enum class TrainEnd { kFinished, kStopped, kTimeLimit };

struct TrainResult {
  TrainEnd end = TrainEnd::kFinished;
  /// Steps done, and those of them that left the weights alone.
  std::int64_t steps = 0;
  std::int64_t skipped = 0;
};

/// What a run is made of.
struct TrainJob {
  Trainee& trainee;
  const SceneSource& training;
  /// None: no validation.
  const SceneSource* validation = nullptr;
  TrainOptions options = {};
  std::filesystem::path folder = {};
  /// Go on from the folder's checkpoint, if there is one by now. Without it the folder, which is
  /// made if need be, must not hold a run.
  bool resume = false;
};

/// Makes a folder for a new run. Throws ConfigError if it holds a run, IoError if it cannot be
/// made.
void require_new_run(const std::filesystem::path& folder);

/// Trains until the last step, the time limit or a request to stop; leaves a checkpoint at each of
/// these ends, and at the last of consecutive steps that had to be skipped.
///
/// Throws ConfigError for options out of range or a resumed run with other ones, IoError for files
/// and lost processes (after a checkpoint), FormatError for a checkpoint that does not fit,
/// NumericalError after TrainOptions::max_skipped steps in a row without finite numbers, and what
/// sources and trainee throw.
TrainResult train(const TrainJob& job, Communicator& processes, TrainObserver& observer);

}  // namespace arbox::training
