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

  KnownPrefix of_objects(std::int64_t first, std::int64_t objects) const {
    return {values.subspan(first * count, objects * count), count};
  }
};

/// K vectors for each object: bins and values (objects, K, D), log probability (objects, K) of the
/// components that were not known. Bins of known components are -1. Where the network's outputs
/// are not finite, values and log probability are NaN.
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
};

/// Independent draws. Row k of object n uses the random numbers (seed, ids[n], k, component) alone.
/// Draws with the same prefix are evaluated once. log_probability is at temperature 1.
Vectors sample(const PackedNetwork& network, const FeatureRows& features,
               std::span<const std::int64_t> ids, std::uint64_t seed, std::int32_t count,
               double temperature, const KnownPrefix& known, const SearchOptions& options);

struct BeamOptions {
  std::int32_t width = 1;
  /// ModeOptions::smoothing.
  double smoothing = 0.0;
};

/// Beam search from one live beam: the `width` best vectors (fewer if there are fewer), best first;
/// missing ones have log probability -infinity. Ties go to the earlier beam, then the lower bin.
Vectors beam_search(const PackedNetwork& network, const FeatureRows& features,
                    const BeamOptions& beam, const KnownPrefix& known,
                    const SearchOptions& options);

/// The components [first, last).
struct ComponentRange {
  std::int32_t first = 0, last = 0;
};

/// (objects, count): log probability of the components in `range` of given vectors (objects, count,
/// D); their values lie on bins.
std::vector<float> log_probability(const PackedNetwork& network, const FeatureRows& features,
                                   std::span<const float> values, std::int32_t count,
                                   const ComponentRange& range, const SearchOptions& options);

/// Calls body(first object, features of a chunk of objects), each with at most
/// options.rows_at_once rows (at least one object).
template <class Body>
void for_chunks(const FeatureRows& features, std::int32_t rows_per_object,
                const SearchOptions& options, const Body& body) {
  const std::int64_t per_object = rows_per_object > 1 ? rows_per_object : 1;
  const std::int64_t most = options.rows_at_once / per_object;
  const std::int64_t at_once = most > 1 ? most : 1;
  for (std::int64_t first = 0; first < features.objects; first += at_once) {
    const std::int64_t left = features.objects - first;
    body(first, FeatureRows{features.values + first * features.width,
                            left < at_once ? left : at_once, features.width});
  }
}

}  // namespace arbox::heads::internal
