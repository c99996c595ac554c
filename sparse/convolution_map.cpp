#include "arbox/sparse/convolution_map.h"

#include <algorithm>
#include <vector>

#include "arbox/base/cpu.h"
#include "arbox/base/parallel.h"
#include "arbox/sparse/internal/convolution_kernel.h"

namespace arbox::sparse {
namespace {

constexpr std::int32_t kTileRows = 256;

struct Kernels {
  std::int32_t (*lanes)();
  void (*pack_weight)(const float*, std::int32_t, std::int32_t, std::int32_t, float*);
  void (*accumulate)(const internal::PairRun&);
  void (*accumulate_weight_gradient)(const internal::WeightGradientRun&);
};

Kernels kernels() {
  using namespace internal;
  switch (simd_level()) {
    case SimdLevel::kAvx512:
      return {avx512::lanes, avx512::pack_weight, avx512::accumulate,
              avx512::accumulate_weight_gradient};
    case SimdLevel::kAvx2:
      return {avx2::lanes, avx2::pack_weight, avx2::accumulate, avx2::accumulate_weight_gradient};
    case SimdLevel::kScalar:
      break;
  }
  return {scalar::lanes, scalar::pack_weight, scalar::accumulate,
          scalar::accumulate_weight_gradient};
}

/// A convolution seen from the side that is written: forward, or backwards to the input.
struct Side {
  std::span<const std::int32_t> from, to;  // positions of each pair
  std::span<const std::int32_t> from_rows, to_rows;
  const float* source;
  std::int32_t source_channels, result_channels;
  float* result;
};

std::vector<float> pack_all(const Kernels& kernel, const float* weight, std::int64_t elements,
                            std::int32_t in_channels, std::int32_t out_channels,
                            std::int32_t columns, int threads) {
  std::vector<float> packed(elements * in_channels * columns);
  parallel_for(elements, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      kernel.pack_weight(weight + k * in_channels * out_channels, in_channels, out_channels,
                         columns, packed.data() + k * in_channels * columns);
    }
  });
  return packed;
}

void write_rows(const Side& side, const Epilogue& epilogue, std::int32_t begin, std::int32_t end,
                const float* tile, std::int32_t columns) {
  for (std::int32_t position = begin; position < end; ++position) {
    const float* sums = tile + std::int64_t{position - begin} * columns;
    float* row = side.result + std::int64_t{side.to_rows[position]} * side.result_channels;
    for (std::int32_t c = 0; c < side.result_channels; ++c) {
      float value = sums[c];
      if (!epilogue.scale.empty()) value *= epilogue.scale[c];
      if (!epilogue.shift.empty()) value += epilogue.shift[c];
      row[c] = epilogue.relu ? std::max(value, 0.0f) : value;
    }
  }
}

void run_tiles(const Kernels& kernel, const Side& side, const std::vector<std::int64_t>& starts,
               const std::vector<float>& packed, std::int32_t columns, const Epilogue& epilogue,
               int threads) {
  const auto rows = static_cast<std::int64_t>(side.to_rows.size());
  const std::int64_t elements = static_cast<std::int64_t>(starts.size()) - 1;
  parallel_for(rows, kTileRows, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> tile((end - begin) * columns, 0.0f);
    std::vector<const float*> inputs(end - begin);
    std::vector<float*> outputs(end - begin);
    for (std::int64_t k = 0; k < elements; ++k) {
      const auto* first = side.to.data() + starts[k];
      const auto* last = side.to.data() + starts[k + 1];
      const auto* from = std::lower_bound(first, last, static_cast<std::int32_t>(begin));
      std::int64_t count = 0;
      for (; from != last && *from < end; ++from, ++count) {
        const std::int32_t source = side.from[from - side.to.data()];
        inputs[count] = side.source + std::int64_t{side.from_rows[source]} * side.source_channels;
        outputs[count] = tile.data() + (*from - begin) * columns;
      }
      if (count == 0) continue;
      kernel.accumulate({inputs.data(), outputs.data(), count,
                         packed.data() + k * side.source_channels * columns, side.source_channels,
                         columns});
    }
    write_rows(side, epilogue, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end),
               tile.data(), columns);
  });
}

std::int32_t padded(const Kernels& kernel, std::int32_t channels) {
  const std::int32_t lanes = kernel.lanes();
  return (channels + lanes - 1) / lanes * lanes;
}

}  // namespace

void convolve(const KernelMap& map, const MapRows& rows, const float* input, const float* weight,
              std::int32_t in_channels, std::int32_t out_channels, float* output,
              const Epilogue& epilogue, int threads) {
  const Kernels kernel = kernels();
  const std::int32_t columns = padded(kernel, out_channels);
  const std::vector<float> packed =
      pack_all(kernel, weight, map.elements(), in_channels, out_channels, columns, threads);
  run_tiles(kernel,
            {map.inputs, map.outputs, rows.inputs, rows.outputs, input, in_channels, out_channels,
             output},
            map.starts, packed, columns, epilogue, threads);
}

void convolve_input_gradient(const KernelMap& map, const MapRows& rows,
                             const float* gradient_output, const float* weight,
                             std::int32_t in_channels, std::int32_t out_channels,
                             float* gradient_input, int threads) {
  const Kernels kernel = kernels();
  const std::int32_t columns = padded(kernel, in_channels);
  const std::int64_t area = std::int64_t{in_channels} * out_channels;
  std::vector<float> transposed(map.elements() * area);
  parallel_for(map.elements(), 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int32_t i = 0; i < in_channels; ++i) {
        for (std::int32_t o = 0; o < out_channels; ++o) {
          transposed[k * area + std::int64_t{o} * in_channels + i] =
              weight[k * area + std::int64_t{i} * out_channels + o];
        }
      }
    }
  });
  const std::vector<float> packed = pack_all(kernel, transposed.data(), map.elements(),
                                             out_channels, in_channels, columns, threads);
  run_tiles(kernel,
            {map.outputs, map.inputs, rows.outputs, rows.inputs, gradient_output, out_channels,
             in_channels, gradient_input},
            map.starts, packed, columns, {}, threads);
}

void convolve_weight_gradient(const KernelMap& map, const MapRows& rows, const float* input,
                              const float* gradient_output, std::int32_t in_channels,
                              std::int32_t out_channels, float* gradient_weight, int threads) {
  constexpr std::int64_t kPairsAtOnce = 128;
  const Kernels kernel = kernels();
  const std::int64_t area = std::int64_t{in_channels} * out_channels;
  std::fill_n(gradient_weight, map.elements() * area, 0.0f);
  parallel_for(map.elements(), 1, threads, [&](std::int64_t begin, std::int64_t end) {
    const float* inputs[kPairsAtOnce];
    const float* outputs[kPairsAtOnce];
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t from = map.starts[k]; from < map.starts[k + 1]; from += kPairsAtOnce) {
        const std::int64_t count = std::min(kPairsAtOnce, map.starts[k + 1] - from);
        for (std::int64_t p = 0; p < count; ++p) {
          inputs[p] = input + std::int64_t{rows.inputs[map.inputs[from + p]]} * in_channels;
          outputs[p] =
              gradient_output + std::int64_t{rows.outputs[map.outputs[from + p]]} * out_channels;
        }
        kernel.accumulate_weight_gradient(
            {inputs, outputs, count, gradient_weight + k * area, in_channels, out_channels});
      }
    }
  });
}

}  // namespace arbox::sparse
