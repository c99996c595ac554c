#include "arbox/sparse/internal/convolution_kernel.h"

// Compiled three times; see arbox_simd_sources in cmake/ArboxTargets.cmake. Nothing inline from a
// library may be used here.

#if defined(__AVX512F__)
#define ARBOX_LANES 16
#elif defined(__AVX2__)
#define ARBOX_LANES 8
#else
#define ARBOX_LANES 4
#endif

namespace arbox::sparse::internal::ARBOX_SIMD {
namespace {

constexpr int kLanes = ARBOX_LANES;
constexpr int kWidest = kLanes == 16 ? 4 : 2;
// Input channels a pass: the weights of one pass stay in the first-level cache.
constexpr int kDepth = 64;

typedef float Vector __attribute__((vector_size(kLanes * sizeof(float))));
typedef float Unaligned __attribute__((vector_size(kLanes * sizeof(float)), aligned(4)));

inline Vector load(const float* from) {
  return (Vector) * reinterpret_cast<const Unaligned*>(from);
}
inline void store(float* to, Vector value) { *reinterpret_cast<Unaligned*>(to) = value; }

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

int vectors_at(int output_begin, int columns) {
  const int left = (columns - output_begin) / kLanes;
  if (left >= kWidest) return kWidest;
  return left >= 2 ? 2 : 1;
}

}  // namespace

std::int32_t lanes() { return kLanes; }

void pack_weight(const float* weight, std::int32_t in_channels, std::int32_t out_channels,
                 std::int32_t out_columns, float* packed) {
  for (int begin = 0; begin < out_columns;) {
    const int width = vectors_at(begin, out_columns) * kLanes;
    for (int c = 0; c < in_channels; ++c) {
      for (int j = 0; j < width; ++j) {
        const int channel = begin + j;
        *packed++ = channel < out_channels ? weight[std::int64_t{c} * out_channels + channel] : 0;
      }
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
  constexpr int kRows = 6;
  const int whole = run.out_channels / kLanes * kLanes;
  for (int row = 0; row < run.in_channels; row += kRows) {
    const int rows = run.in_channels - row < kRows ? run.in_channels - row : kRows;
    for (int begin = 0; begin < whole; begin += kLanes * 2) {
      const bool two = begin + 2 * kLanes <= whole;
      const int second = two ? begin + kLanes : begin;
      Vector sums[kRows][2] = {};
      for (std::int64_t p = 0; p < run.count; ++p) {
        const Vector low = load(run.outputs[p] + begin), high = load(run.outputs[p] + second);
        const float* input = run.inputs[p] + row;
        if (rows == kRows) {
#pragma GCC unroll 6
          for (int r = 0; r < kRows; ++r) {
            sums[r][0] += input[r] * low;
            sums[r][1] += input[r] * high;
          }
        } else {
          for (int r = 0; r < rows; ++r) {
            sums[r][0] += input[r] * low;
            sums[r][1] += input[r] * high;
          }
        }
      }
      for (int r = 0; r < rows; ++r) {
        float* to = run.gradient + std::int64_t{row + r} * run.out_channels;
        store(to + begin, load(to + begin) + sums[r][0]);
        if (two) store(to + second, load(to + second) + sums[r][1]);
      }
    }
    for (int channel = whole; channel < run.out_channels; ++channel) {
      for (int r = 0; r < rows; ++r) {
        float sum = 0;
        for (std::int64_t p = 0; p < run.count; ++p) {
          sum += run.inputs[p][row + r] * run.outputs[p][channel];
        }
        run.gradient[std::int64_t{row + r} * run.out_channels + channel] += sum;
      }
    }
  }
}

}  // namespace arbox::sparse::internal::ARBOX_SIMD
