#include <algorithm>
#include <memory>
#include <vector>

#include "arbox/base/parallel.h"
#include "arbox/sparse/convolution_map.h"
#include "arbox/sparse/internal/kernel_table.h"

namespace arbox::sparse {
namespace {

// Pairs whose rows stay in the first-level cache while every block of channels passes over them.
constexpr std::int64_t kPairsAtOnce = 64;
constexpr std::int64_t kGradientTileRows = 512;
constexpr std::int32_t kLineFloats = 16;
constexpr std::int64_t kWorkspace = 32 << 20;
constexpr std::int64_t kMostRanges = 16;

struct Problem {
  const KernelMap& map;
  const MapRows& rows;
  const float* input;
  const float* gradient_output;
  std::int32_t in_channels, out_channels, columns;

  std::int64_t area() const { return std::int64_t{in_channels} * columns; }
};

/// Adds the pairs [begin, end) of the map, all of one element, to `gradient`.
void add_pairs(const internal::KernelTable& kernel, const Problem& problem, std::int64_t begin,
               std::int64_t end, std::vector<float>& padded, float* gradient) {
  const auto& [map, rows, input, gradient_output, in_channels, out_channels, columns] = problem;
  const float* inputs[kPairsAtOnce];
  const float* outputs[kPairsAtOnce];
  const auto input_of = [&](std::int64_t pair) {
    return input + std::int64_t{rows.inputs[map.inputs[pair]]} * in_channels;
  };
  for (std::int64_t from = begin; from < end; from += kPairsAtOnce) {
    const std::int64_t count = std::min(kPairsAtOnce, end - from);
    // The rows of the next pairs come from afar while these are multiplied.
    for (std::int64_t p = from + count; p < std::min(from + count + kPairsAtOnce, end); ++p) {
      const float* row = input_of(p);
      for (std::int32_t c = 0; c < in_channels; c += kLineFloats) __builtin_prefetch(row + c);
    }
    for (std::int64_t p = 0; p < count; ++p) {
      inputs[p] = input_of(from + p);
      outputs[p] =
          gradient_output + std::int64_t{rows.outputs[map.outputs[from + p]]} * out_channels;
      if (columns == out_channels) continue;
      float* copy = padded.data() + p * columns;
      std::copy_n(outputs[p], out_channels, copy);
      outputs[p] = copy;
    }
    kernel.accumulate_weight_gradient({inputs, outputs, count, gradient, in_channels, columns});
  }
}

/// Adds the pairs of the outputs [begin, end), tile by tile.
void add_range(const internal::KernelTable& kernel, const Problem& problem, std::int64_t begin,
               std::int64_t end, float* gradient) {
  const KernelMap& map = problem.map;
  const std::int64_t elements = map.elements();
  std::vector<float> padded(kPairsAtOnce * problem.columns, 0.0f);
  std::vector<std::int64_t> next(elements);
  for (std::int64_t k = 0; k < elements; ++k) {
    const auto* first = map.outputs.data() + map.starts[k];
    const auto* last = map.outputs.data() + map.starts[k + 1];
    next[k] = std::lower_bound(first, last, static_cast<std::int32_t>(begin)) - map.outputs.data();
  }
  for (std::int64_t tile = begin; tile < end; tile += kGradientTileRows) {
    const std::int64_t tile_end = std::min(end, tile + kGradientTileRows);
    for (std::int64_t k = 0; k < elements; ++k) {
      const std::int64_t from = next[k];
      while (next[k] < map.starts[k + 1] && map.outputs[next[k]] < tile_end) ++next[k];
      add_pairs(kernel, problem, from, next[k], padded, gradient + k * problem.area());
    }
  }
}

void sum_ranges(const Problem& problem, const float* parts, std::int64_t ranges,
                float* gradient_weight, int threads) {
  const std::int64_t all = problem.map.elements() * problem.in_channels;
  parallel_for(all, 256, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      float* to = gradient_weight + row * problem.out_channels;
      std::copy_n(parts + row * problem.columns, problem.out_channels, to);
      for (std::int64_t r = 1; r < ranges; ++r) {
        const float* from = parts + (r * all + row) * problem.columns;
        for (std::int32_t c = 0; c < problem.out_channels; ++c) to[c] += from[c];
      }
    }
  });
}

}  // namespace

void convolve_weight_gradient(const KernelMap& map, const MapRows& rows, const float* input,
                              const float* gradient_output, std::int32_t in_channels,
                              std::int32_t out_channels, float* gradient_weight, int threads) {
  const internal::KernelTable kernel = internal::kernel_table();
  const Problem problem{
      map, rows, input, gradient_output, in_channels, out_channels, kernel.padded(out_channels)};
  const std::int64_t total = map.elements() * problem.area();
  if (total == 0) return;
  const auto outputs = static_cast<std::int64_t>(rows.outputs.size());
  const std::int64_t ranges = std::clamp(
      std::min(kWorkspace / (total * std::int64_t{sizeof(float)}), outputs / kGradientTileRows),
      std::int64_t{1}, kMostRanges);
  const auto parts = std::make_unique<float[]>(ranges * total);
  if (ranges > 1) {
    const std::int64_t length = (outputs + ranges - 1) / ranges;
    parallel_for(ranges, 1, threads, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t r = begin; r < end; ++r) {
        add_range(kernel, problem, r * length, std::min(outputs, (r + 1) * length),
                  parts.get() + r * total);
      }
    });
  } else {
    parallel_for(map.elements(), 1, threads, [&](std::int64_t begin, std::int64_t end) {
      std::vector<float> padded(kPairsAtOnce * problem.columns, 0.0f);
      for (std::int64_t k = begin; k < end; ++k) {
        add_pairs(kernel, problem, map.starts[k], map.starts[k + 1], padded,
                  parts.get() + k * problem.area());
      }
    });
  }
  sum_ranges(problem, parts.get(), ranges, gradient_weight, threads);
}

}  // namespace arbox::sparse
