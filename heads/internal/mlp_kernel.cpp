#include "arbox/heads/internal/mlp_kernel.h"

#include "arbox/base/internal/float_lanes.h"

// Compiled three times; see arbox_simd_sources in cmake/ArboxTargets.cmake. Nothing inline from a
// library may be used here.

namespace arbox::heads::internal::ARBOX_SIMD {
namespace {

using namespace arbox::internal::ARBOX_SIMD;

constexpr int kVectors = kLanes == 16 ? 4 : 2;
constexpr int kPanel = kLanes * kVectors;
// Rows and inputs of one pass of the innermost loop: the sums stay in registers, the weights of the
// pass in the second-level cache.
constexpr int kTile = kLanes == 4 ? 4 : 6;
constexpr int kDepth = 256;

inline Vector leaky(Vector value, float leak) { return value > 0.0f ? value : value * leak; }

/// Inputs [begin, begin + depth) of kRows rows, a panel of outputs.
template <int kRows>
inline void tile(const LayerRun& run, std::int64_t row, int column, int begin, int depth,
                 const float* weight) {
  Vector sums[kRows][kVectors];
  const float* inputs[kRows];
  float* output = run.output + row * run.output_stride + column;
  const float* start = begin == 0 ? run.bias + column : output;
  const std::int64_t start_stride = begin == 0 ? 0 : run.output_stride;
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
    inputs[r] = run.input + (row + r) * run.input_stride + begin;
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) sums[r][v] = load(start + r * start_stride + v * kLanes);
  }
  for (int k = 0; k < depth; ++k) {
    Vector w[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) w[v] = load(weight + k * kPanel + v * kLanes);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const float x = inputs[r][k];
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sums[r][v] += x * w[v];
    }
  }
  const bool last = begin + depth == run.in;
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      store(output + r * run.output_stride + v * kLanes,
            last ? leaky(sums[r][v], run.leak) : sums[r][v]);
    }
  }
}

inline Vector exponential(Vector x) {
  const Vector rounder = Vector{} + 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer
  const Vector shifted = x * 1.44269504f + rounder;
  const Vector n = shifted - rounder;
  const Vector r = x - n * 0.693359375f + n * 2.12194440e-4f;
  Vector p = r * 1.9875691500e-4f + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * r * r + r + 1.0f;
  const Vector scaled = (Vector)((Integers)p + ((Integers)shifted << 23));
  return x > -87.0f ? scaled : Vector{};
}

}  // namespace

std::int32_t panel_columns() { return kPanel; }

void layer(const LayerRun& run) {
  for (int column = 0; column < run.columns; column += kPanel) {
    const float* panel = run.weight + std::int64_t{column} * run.in;
    for (int begin = 0; begin < run.in; begin += kDepth) {
      const int depth = run.in - begin < kDepth ? run.in - begin : kDepth;
      const float* weight = panel + std::int64_t{begin} * kPanel;
      std::int64_t row = 0;
      for (; row + kTile <= run.rows; row += kTile) {
        tile<kTile>(run, row, column, begin, depth, weight);
      }
      for (; row + 2 <= run.rows; row += 2) tile<2>(run, row, column, begin, depth, weight);
      if (row < run.rows) tile<1>(run, row, column, begin, depth, weight);
    }
  }
}

void add_prefix(const PrefixRun& run) {
  for (int column = 0; column < run.columns; column += kLanes) {
    Vector sum = load(run.base + column);
    for (int j = 0; j < run.count; ++j) {
      sum += run.values[j] * load(run.columns_of_values + j * run.columns + column);
    }
    store(run.output + column, leaky(sum, run.leak));
  }
}

float largest(const float* logits, std::int32_t columns) {
  Vector top = load(logits);
  for (int column = kLanes; column < columns; column += kLanes) {
    const Vector next = load(logits + column);
    top = next > top ? next : top;
  }
  float result = top[0];
  for (int lane = 1; lane < kLanes; ++lane) result = top[lane] > result ? top[lane] : result;
  return result;
}

void exponentials(const float* logits, std::int32_t columns, float top, float scale, float* values,
                  float* sums) {
  for (int block = 0; block < columns; block += kColumnBlock) {
    Vector sum = {};
    for (int column = block; column < block + kColumnBlock; column += kLanes) {
      const Vector value = exponential((load(logits + column) - top) * scale);
      store(values + column, value);
      sum += value;
    }
    float total = 0.0f;
    for (int lane = 0; lane < kLanes; ++lane) total += sum[lane];
    *sums++ = total;
  }
}

}  // namespace arbox::heads::internal::ARBOX_SIMD
