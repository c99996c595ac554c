#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/heads/internal/conditional_network.h"

namespace arbox::heads::internal {

/// Fixed values of the first components (known sizes), (objects, count); count may be 0.
struct KnownPrefix {
  std::span<const float> values = {};
  std::int32_t count = 0;
};

/// K vectors for each object: bins and values (objects, K, D), log probability (objects, K) of the
/// components that were not known.
struct Vectors {
  std::int64_t objects = 0;
  std::int32_t count = 0, components = 0;
  std::vector<std::int32_t> bins;
  std::vector<float> values;
  std::vector<float> log_probability;
};

struct SearchOptions {
  int threads = 0;
  /// Rows that are evaluated together: bounds the memory whatever the number of objects.
  std::int32_t rows_at_once = 2048;
  float leak = 0.1f;
};

/// Independent draws. Row k of object n uses the random numbers (seed, ids[n], k, component) alone.
/// Draws with the same prefix are evaluated once. log_probability is at temperature 1.
Vectors sample(std::span<const ComponentWeights> components, const FeatureRows& features,
               std::span<const std::int64_t> ids, std::uint64_t seed, std::int32_t count,
               double temperature, const KnownPrefix& known, const SearchOptions& options);

/// Beam search from one live beam: the `width` best vectors (fewer if there are fewer), best first;
/// missing ones have log probability -infinity. Ties go to the earlier beam, then the lower bin.
Vectors beam_search(std::span<const ComponentWeights> components, const FeatureRows& features,
                    std::int32_t width, const KnownPrefix& known, const SearchOptions& options);

/// (objects, count): log probability of given vectors, whose values (objects, count, D) lie on
/// bins from component `known` on.
std::vector<float> log_probability(std::span<const ComponentWeights> components,
                                   const FeatureRows& features, std::span<const float> values,
                                   std::int32_t count, std::int32_t known,
                                   const SearchOptions& options);

}  // namespace arbox::heads::internal
