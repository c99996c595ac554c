#pragma once

#include <cstdint>
#include <vector>

namespace arbox::training {

/// In which order a run visits the scenes of a source: each epoch is a permutation that depends on
/// seed and epoch alone. One permutation is held in memory; not for use by several threads at once.
class SceneOrder {
 public:
  /// `scenes` >= 1 of the source; throws InvalidArgument otherwise.
  SceneOrder(std::uint64_t seed, std::int64_t scenes);

  /// The scene at place `position` >= 0 of the run's endless sequence; places [k * scenes, (k + 1)
  /// * scenes) are epoch k.
  std::int64_t at(std::int64_t position);

 private:
  void shuffle(std::int64_t epoch);

  std::uint64_t seed_;
  std::int64_t epoch_ = -1;
  std::vector<std::int64_t> permutation_;
};

/// Places of the run's sequence that one process has of a batch.
struct BatchShare {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// Batch number `batch` of `batch_size` scenes is cut into `processes` runs that differ in length
/// by at most one.
BatchShare batch_share(std::int64_t batch, std::int64_t batch_size, int process, int processes);

}  // namespace arbox::training
