#pragma once

#include <cstdint>
#include <span>
#include <vector>

// Inference of a set abstraction without tensors: everything about a ball stays in the cache.

namespace arbox::sparse::internal {

/// A layer after the first: row-major weight (in, out) with the norm's scale folded in, and shift.
struct AbstractionLayer {
  const float* weight;
  const float* shift;
  std::int32_t in_channels, out_channels;
};

struct AbstractionProblem {
  const float* points;        ///< (N, 3)
  const float* centres;       ///< (M, 3)
  const std::int64_t* index;  ///< (M, samples), -1 throughout for an empty ball
  std::int64_t centre_count;
  std::int32_t samples;
  const float* projected;        ///< (N, width): first layer of the features, scale folded in
  const float* position_weight;  ///< (3, width): first layer of the positions, likewise
  const float* first_shift;      ///< (width)
  std::int32_t width;
  std::vector<AbstractionLayer> layers;
};

/// output (M, channels of the last layer). Repeated neighbours, as ball_query pads, cost nothing.
void abstract_balls(const AbstractionProblem& problem, float* output, int threads = 0);

}  // namespace arbox::sparse::internal
