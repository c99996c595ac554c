#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "arbox/training/train_options.h"

namespace arbox::training {

using NamedTensors = std::map<std::string, at::Tensor>;

/// Where a run stands. Random numbers are functions of the seed and of places in the run, so that
/// the next step depends on nothing else.
struct Checkpoint {
  /// Steps done.
  std::int64_t step = 0;
  /// The step that was validated last; -1 for none.
  std::int64_t validated = -1;
  /// Steps that were skipped for numbers that are not finite, in all and up to now in a row.
  std::int64_t skipped = 0;
  std::int64_t skipped_in_row = 0;
  /// Time spent, without pauses.
  double seconds = 0;
  /// The highest value of TrainOptions::best so far, and its step; -1 for none.
  double best = 0;
  std::int64_t best_step = -1;
  /// Scenes of the training data.
  std::int64_t scenes = 0;
  TrainOptions options = {};
  /// Parameters, buffers and moments by name.
  NamedTensors tensors = {};
};

/// The file of a run's checkpoint within its folder.
std::filesystem::path checkpoint_file(const std::filesystem::path& folder);

/// Writes durably (durable_file.h). Throws IoError.
void write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// Throws IoError, FormatError.
Checkpoint read_checkpoint(const std::filesystem::path& path);

}  // namespace arbox::training
