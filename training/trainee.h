#pragma once

#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "arbox/training/communicator.h"
#include "arbox/training/scene.h"

namespace arbox::training {

/// Where random choices come from: those about scene i of a step are addressed by (seed,
/// first_scene + i), whatever the number of processes.
struct Step {
  /// Counts calls of Trainee::loss; a step of the optimiser may take several.
  std::int64_t number = 0;
  std::uint64_t seed = 0;
  /// Place of the first scene in the run's sequence of scenes.
  std::int64_t first_scene = 0;
};

struct StepLoss {
  /// Scalar with gradient: this process's share, so that the shares of all processes add up to the
  /// loss of the whole batch.
  at::Tensor total;
  /// Parts by name, for logs.
  std::map<std::string, double> terms;
};

/// A network as the trainer sees it.
class Trainee {
 public:
  virtual ~Trainee() = default;

  virtual torch::nn::Module& network() = 0;

  /// Changes a scene before its loss is asked (augmentation), with random choices addressed by
  /// (seed, place). Called on loader threads, several at once.
  virtual void prepare(Scene& /*scene*/, std::uint64_t /*seed*/, std::int64_t /*place*/) const {}

  /// Loss of the scenes that this process has of the step's batch, at least one. Counts that losses
  /// are divided by are summed over `processes`. The network is in training mode but for its frozen
  /// parts.
  ///
  /// With several processes, each must sum the same things in the same order, and batch norms share
  /// their statistics in forward and backward: call the same batch norms for every batch, also with
  /// no rows, and let what they give be part of the loss (times 0 if need be).
  virtual StepLoss loss(std::span<const Scene> scenes, const Step& step,
                        Communicator& processes) = 0;

  /// Figures by name on scenes of a validation source ("Car 3d R40 moderate", ...); the network is
  /// in eval mode.
  virtual std::map<std::string, double> evaluate(const SceneSource& scenes) = 0;

  /// Writes the model as users load it.
  virtual void save(const std::filesystem::path& path) = 0;
};

}  // namespace arbox::training
