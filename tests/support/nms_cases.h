#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "arbox/geometry/nms.h"
#include "arbox/geometry/overlap.h"

/// \file
/// Proposals like a detector's, and suppression as one would write it down: the oracle of the
/// tests and the baseline of the benchmark.

namespace arbox::testing {

struct ScoredBoxes {
  std::vector<geometry::Box> boxes;
  std::vector<double> scores;
};

/// `count` car proposals around `clusters` places in 70 m x 70 m; of clusters == count they lie
/// anywhere.
inline ScoredBoxes proposals(std::mt19937_64& random, int count, int clusters) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  struct Place {
    double x, y, yaw;
  };
  std::vector<Place> places;
  for (int i = 0; i < clusters; ++i) {
    places.push_back(
        {70 * unit(random), 70 * unit(random) - 35, std::numbers::pi * (2 * unit(random) - 1)});
  }
  ScoredBoxes result;
  for (int i = 0; i < count; ++i) {
    const Place& place = places[i % clusters];
    result.boxes.push_back(geometry::make_yaw_box(
        {place.x + 0.27 * normal(random), place.y + 0.27 * normal(random),
         -1 + 0.1 * normal(random)},
        {3.9 * std::exp(0.05 * normal(random)), 1.6 * std::exp(0.05 * normal(random)),
         1.56 * std::exp(0.05 * normal(random))},
        place.yaw + 0.05 * normal(random)));
    result.scores.push_back(unit(random));
  }
  return result;
}

inline std::vector<std::int64_t> by_score(const std::vector<double>& scores) {
  std::vector<std::int64_t> order(scores.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int64_t a, std::int64_t b) { return scores[a] > scores[b]; });
  return order;
}

inline std::vector<std::int64_t> naive_nms(const ScoredBoxes& input, double threshold,
                                           geometry::OverlapSpace space,
                                           const std::vector<int>& classes = {}) {
  const auto order = by_score(input.scores);
  std::vector<char> gone(order.size(), 0);
  std::vector<std::int64_t> kept;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (gone[i]) continue;
    kept.push_back(order[i]);
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      if (gone[j] || (!classes.empty() && classes[order[i]] != classes[order[j]])) continue;
      gone[j] = geometry::overlap(input.boxes[order[i]], input.boxes[order[j]], {.space = space}) >
                threshold;
    }
  }
  return kept;
}

}  // namespace arbox::testing
