#include "arbox/sparse/internal/convolution_kernel.h"

#include "arbox/base/internal/float_lanes.h"

// Compiled three times; see arbox_simd_sources in cmake/ArboxTargets.cmake. Nothing inline from a
// library may be used here.

namespace arbox::sparse::internal::ARBOX_SIMD {
namespace {

using namespace arbox::internal::ARBOX_SIMD;

constexpr int kWidest = kLanes == 16 ? 4 : 2;
// Input channels a pass: the weights of one pass stay in the first-level cache.
constexpr int kDepth = 64;

template <int kRows, int kVectors>
inline void block(const float* const* inputs, float* const* outputs, int input_begin,
                  int output_begin, const float* weight, int depth) {
  Vector sums[kRows][kVectors];
  const float* rows[kRows];
#pragma GCC unroll 16
  for (int r = 0; r < kRows; ++r) {
    rows[r] = inputs[r] + input_begin;
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) sums[r][v] = load(outputs[r] + output_begin + v * kLanes);
  }
  for (int c = 0; c < depth; ++c) {
    Vector w[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) w[v] = load(weight + (c * kVectors + v) * kLanes);
#pragma GCC unroll 16
    for (int r = 0; r < kRows; ++r) {
      const float x = rows[r][c];
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sums[r][v] += x * w[v];
    }
  }
#pragma GCC unroll 16
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) store(outputs[r] + output_begin + v * kLanes, sums[r][v]);
  }
}

template <int kRows, int kVectors>
void column(const PairRun& run, int input_begin, int depth, int output_begin, const float* weight) {
  std::int64_t i = 0;
  for (; i + kRows <= run.count; i += kRows) {
    block<kRows, kVectors>(run.inputs + i, run.outputs + i, input_begin, output_begin, weight,
                           depth);
  }
  if constexpr (kRows >= 4) {
    for (; i + 2 <= run.count; i += 2) {
      block<2, kVectors>(run.inputs + i, run.outputs + i, input_begin, output_begin, weight, depth);
    }
  }
  for (; i < run.count; ++i) {
    block<1, kVectors>(run.inputs + i, run.outputs + i, input_begin, output_begin, weight, depth);
  }
}

template <int kRows, int kVectors>
inline void outer_block(const WeightGradientRun& run, int row, int begin) {
  Vector sums[kRows][kVectors] = {};
  for (std::int64_t p = 0; p < run.count; ++p) {
    const float* input = run.inputs[p] + row;
    const float* output = run.outputs[p] + begin;
    Vector g[kVectors];
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) g[v] = load(output + v * kLanes);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const float x = input[r];
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) sums[r][v] += x * g[v];
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
    float* to = run.gradient + std::int64_t{row + r} * run.out_columns + begin;
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) {
      store(to + v * kLanes, load(to + v * kLanes) + sums[r][v]);
    }
  }
}

template <int kVectors>
void outer_products(const WeightGradientRun& run, int begin) {
  constexpr int kMostRows = kLanes == 16 ? 8 : 4;
  int row = 0;
  for (; row + kMostRows <= run.in_channels; row += kMostRows) {
    outer_block<kMostRows, kVectors>(run, row, begin);
  }
  for (; row + 2 <= run.in_channels; row += 2) outer_block<2, kVectors>(run, row, begin);
  for (; row < run.in_channels; ++row) outer_block<1, kVectors>(run, row, begin);
}

int vectors_at(int output_begin, int columns) {
  const int left = (columns - output_begin) / kLanes;
  if (left >= kWidest) return kWidest;
  return left >= 2 ? 2 : 1;
}

}  // namespace

std::int32_t lanes() { return kLanes; }

void pack_weight(const WeightMatrix& weight, std::int32_t out_columns, float* packed) {
  for (int begin = 0; begin < out_columns;) {
    const int width = vectors_at(begin, out_columns) * kLanes;
    const int left = weight.out_channels - begin;
    const int used = left < width ? left : width;
    const float* from = weight.data + begin * weight.out_step;
    for (int c = 0; c < weight.in_channels; ++c, packed += width) {
      const float* row = from + c * weight.in_step;
      for (int j = 0; j < used; ++j) packed[j] = row[j * weight.out_step];
      for (int j = used; j < width; ++j) packed[j] = 0;
    }
    begin += width;
  }
}

void accumulate(const PairRun& run) {
  for (int input_begin = 0; input_begin < run.in_channels; input_begin += kDepth) {
    const int left = run.in_channels - input_begin;
    const int depth = left < kDepth ? left : kDepth;
    for (int begin = 0; begin < run.out_columns;) {
      const int vectors = vectors_at(begin, run.out_columns);
      const float* weight = run.weight + std::int64_t{begin} * run.in_channels +
                            std::int64_t{input_begin} * vectors * kLanes;
      if constexpr (kLanes == 16) {
        if (vectors == 4) column<6, 4>(run, input_begin, depth, begin, weight);
        if (vectors == 2) column<8, 2>(run, input_begin, depth, begin, weight);
        if (vectors == 1) column<8, 1>(run, input_begin, depth, begin, weight);
      } else {
        if (vectors == 2) column<4, 2>(run, input_begin, depth, begin, weight);
        if (vectors == 1) column<8, 1>(run, input_begin, depth, begin, weight);
      }
      begin += vectors * kLanes;
    }
  }
}

void accumulate_weight_gradient(const WeightGradientRun& run) {
  for (int begin = 0; begin < run.out_columns;) {
    const bool two = begin + 2 * kLanes <= run.out_columns;
    if (two) outer_products<2>(run, begin);
    if (!two) outer_products<1>(run, begin);
    begin += two ? 2 * kLanes : kLanes;
  }
}

}  // namespace arbox::sparse::internal::ARBOX_SIMD
