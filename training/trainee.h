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

/// What a step is: all random choices of a loss are addressed by seed and step.
struct Step {
  std::int64_t number = 0;
  std::uint64_t seed = 0;
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

  /// Loss of the scenes that this process has of the step's batch. Counts that losses are divided
  /// by are summed over `processes`. The network is in training mode but for its frozen parts.
  virtual StepLoss loss(std::span<const Scene> scenes, const Step& step,
                        Communicator& processes) = 0;

  /// Figures by name on scenes of a validation source ("Car 3d R40 moderate", ...); the network is
  /// in eval mode.
  virtual std::map<std::string, double> evaluate(const SceneSource& scenes) = 0;

  /// Writes the model as users load it.
  virtual void save(const std::filesystem::path& path) = 0;
};

}  // namespace arbox::training
