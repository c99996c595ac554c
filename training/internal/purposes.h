#pragma once

#include <cstdint>

namespace arbox::training::internal {

/// Uses of random numbers about one scene of a run (RandomStream's purpose).
inline constexpr std::uint32_t kPastedObjects = 700;
inline constexpr std::uint32_t kGlobalAugmentation = 701;
inline constexpr std::uint32_t kSampledProposals = 702;

}  // namespace arbox::training::internal
