#include "arbox/training/scene_order.h"

#include <numeric>
#include <string>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/random.h"

namespace arbox::training {
namespace {

constexpr std::uint32_t kPurpose = 0x5ce7e0;

}  // namespace

SceneOrder::SceneOrder(std::uint64_t seed, std::int64_t scenes) : seed_(seed) {
  if (scenes < 1 || scenes > UINT32_MAX) {
    throw InvalidArgument("SceneOrder: expected 1 to 4294967295 scenes, got " +
                          std::to_string(scenes));
  }
  permutation_.resize(static_cast<std::size_t>(scenes));
}

std::int64_t SceneOrder::at(std::int64_t position) {
  const auto scenes = static_cast<std::int64_t>(permutation_.size());
  if (position / scenes != epoch_) shuffle(position / scenes);
  return permutation_[static_cast<std::size_t>(position % scenes)];
}

void SceneOrder::shuffle(std::int64_t epoch) {
  epoch_ = epoch;
  std::iota(permutation_.begin(), permutation_.end(), 0);
  const RandomStream random(seed_, static_cast<std::uint64_t>(epoch), kPurpose);
  for (std::size_t left = permutation_.size(); left > 1; --left) {
    const auto chosen =
        random.below(static_cast<std::uint32_t>(left), static_cast<std::uint32_t>(left));
    std::swap(permutation_[left - 1], permutation_[chosen]);
  }
}

BatchShare batch_share(std::int64_t batch, std::int64_t batch_size, int process, int processes) {
  const std::int64_t begin = batch_size * process / processes;
  const std::int64_t end = batch_size * (process + 1) / processes;
  return {batch * batch_size + begin, end - begin};
}

}  // namespace arbox::training
