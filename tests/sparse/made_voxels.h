#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "arbox/sparse/coordinate_set.h"

namespace arbox::sparse {

/// `count` distinct voxels in random order, coordinates in [low, low + extent), on multiples of
/// `step`.
inline std::vector<Coordinate> random_voxels(std::uint32_t seed, std::size_t count,
                                             std::int32_t batches, std::int32_t low,
                                             std::int32_t extent, std::int32_t step = 1) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::int32_t> batch(0, batches - 1), cell(0, extent - 1);
  std::set<std::tuple<int, int, int, int>> seen;
  std::vector<Coordinate> result;
  while (result.size() < count) {
    const std::tuple<int, int, int, int> c{batch(random), (low + cell(random)) * step,
                                           (low + cell(random)) * step,
                                           (low + cell(random)) * step};
    if (!seen.insert(c).second) continue;
    result.push_back({std::get<0>(c), std::get<1>(c), std::get<2>(c), std::get<3>(c)});
  }
  return result;
}

inline std::vector<float> random_numbers(std::uint32_t seed, std::size_t count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> result(count);
  std::generate(result.begin(), result.end(), [&] { return uniform(random); });
  return result;
}

}  // namespace arbox::sparse
