#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "arbox/training/trainee.h"

namespace arbox::training::testing {

/// Small clouds of different sizes around a box, by number.
class ToyScenes : public SceneSource {
 public:
  explicit ToyScenes(std::int64_t count, std::uint64_t seed = 1) : count_(count), seed_(seed) {}

  std::int64_t size() const override { return count_; }
  Scene scene(std::int64_t index) const override;

  /// This scene's object is not finite; -1 for none.
  std::int64_t poisoned = -1;
  /// Asking for this scene throws IoError; -1 for none.
  std::int64_t missing = -1;

 private:
  std::int64_t count_;
  std::uint64_t seed_;
};

struct ToyOptions {
  bool double_precision = false;
  bool dropout = false;
  std::uint64_t seed = 3;
  /// Sleeps so long in every loss.
  int delay_milliseconds = 0;
};

/// Sparse convolutions with batch norms that tell where the object of a scene is.
class ToyTrainee : public Trainee {
 public:
  explicit ToyTrainee(const ToyOptions& options);
  ~ToyTrainee() override;

  torch::nn::Module& network() override;
  void prepare(Scene& scene, std::uint64_t seed, std::int64_t place) const override;
  StepLoss loss(std::span<const Scene> scenes, const Step& step, Communicator& processes) override;
  /// Figures "error" (mean distance, metres) and "closeness" (its negative).
  std::map<std::string, double> evaluate(const SceneSource& scenes) override;
  void save(const std::filesystem::path& path) override;

 private:
  class Network;

  ToyOptions options_;
  std::shared_ptr<Network> network_;
};

}  // namespace arbox::training::testing
