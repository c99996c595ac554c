#include "arbox/sparse/convolution_map.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "arbox/base/parallel.h"
#include "arbox/sparse/internal/kernel_table.h"

namespace arbox::sparse {
namespace {

using internal::KernelTable;
using internal::WeightMatrix;

constexpr std::int64_t kTileRows = 256;
// Fewer tiles than this are also cut by columns, so that small levels keep all threads busy.
constexpr std::int64_t kFewTiles = 8;
// The widest block of columns of any kernel: slices start at multiples of it.
constexpr std::int32_t kSliceColumns = 64;

/// A convolution seen from the side that is written: forward, or backwards to the input.
struct Side {
  std::span<const std::int32_t> from, to;  // positions of each pair
  std::span<const std::int32_t> from_rows, to_rows;
  std::span<const std::int64_t> starts;
  const float* source;
  std::int32_t source_channels, result_channels;
  float* result;
};

struct Slice {
  std::int64_t row_begin, row_end;
  std::int32_t column_begin, column_end;  // of the padded columns

  std::int32_t width() const { return column_end - column_begin; }
};

struct PackedWeights {
  std::unique_ptr<float[]> data;
  std::int32_t columns;
};

PackedWeights pack_all(const KernelTable& kernel, const WeightMatrix& first, std::int64_t elements,
                       int threads) {
  const std::int32_t columns = kernel.padded(first.out_channels);
  const std::int64_t area = std::int64_t{first.in_channels} * first.out_channels;
  const std::int64_t packed_area = std::int64_t{first.in_channels} * columns;
  auto data = std::make_unique_for_overwrite<float[]>(elements * packed_area);
  parallel_for(elements, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      WeightMatrix weight = first;
      weight.data += k * area;
      kernel.pack_weight(weight, columns, data.get() + k * packed_area);
    }
  });
  return {std::move(data), columns};
}

void write_rows(const Side& side, const Epilogue& epilogue, const Slice& slice, float* tile) {
  const std::int32_t channels =
      std::min(slice.column_end, side.result_channels) - slice.column_begin;
  const float* scale = epilogue.scale.empty() ? nullptr : epilogue.scale.data();
  const float* shift = epilogue.shift.empty() ? nullptr : epilogue.shift.data();
  for (std::int64_t position = slice.row_begin; position < slice.row_end; ++position) {
    float* sums = tile + (position - slice.row_begin) * slice.width();
    const std::int64_t start =
        std::int64_t{side.to_rows[position]} * side.result_channels + slice.column_begin;
    if (scale != nullptr) {
      for (std::int32_t c = 0; c < channels; ++c) sums[c] *= scale[slice.column_begin + c];
    }
    if (shift != nullptr) {
      for (std::int32_t c = 0; c < channels; ++c) sums[c] += shift[slice.column_begin + c];
    }
    if (epilogue.residual != nullptr) {
      const float* residual = epilogue.residual + start;
      for (std::int32_t c = 0; c < channels; ++c) sums[c] += residual[c];
    }
    if (epilogue.relu) {
      for (std::int32_t c = 0; c < channels; ++c) sums[c] = std::max(sums[c], 0.0f);
    }
    std::copy_n(sums, channels, side.result + start);
  }
}

void run_slice(const KernelTable& kernel, const Side& side, const PackedWeights& weights,
               const Slice& slice, const Epilogue& epilogue) {
  const std::int64_t rows = slice.row_end - slice.row_begin;
  std::vector<float> tile(rows * slice.width(), 0.0f);
  std::vector<const float*> inputs(rows);
  std::vector<float*> outputs(rows);
  const std::int64_t area = std::int64_t{side.source_channels} * weights.columns;
  for (std::size_t k = 0; k + 1 < side.starts.size(); ++k) {
    const auto* first = side.to.data() + side.starts[k];
    const auto* last = side.to.data() + side.starts[k + 1];
    const auto* to = std::lower_bound(first, last, static_cast<std::int32_t>(slice.row_begin));
    std::int64_t count = 0;
    for (; to != last && *to < slice.row_end; ++to, ++count) {
      const std::int32_t source = side.from[to - side.to.data()];
      inputs[count] = side.source + std::int64_t{side.from_rows[source]} * side.source_channels;
      outputs[count] = tile.data() + (*to - slice.row_begin) * slice.width();
    }
    if (count == 0) continue;
    kernel.accumulate({inputs.data(), outputs.data(), count,
                       weights.data.get() + static_cast<std::int64_t>(k) * area +
                           std::int64_t{slice.column_begin} * side.source_channels,
                       side.source_channels, slice.width()});
  }
  write_rows(side, epilogue, slice, tile.data());
}

void run_tiles(const KernelTable& kernel, const Side& side, const PackedWeights& weights,
               const Epilogue& epilogue, int threads) {
  const auto rows = static_cast<std::int64_t>(side.to_rows.size());
  const std::int64_t tiles = (rows + kTileRows - 1) / kTileRows;
  if (tiles == 0) return;
  const std::int64_t tile_rows = (rows + tiles - 1) / tiles;
  const std::int32_t step = tiles < kFewTiles ? kSliceColumns : weights.columns;
  const std::int64_t slices = (weights.columns + step - 1) / step;
  parallel_for(tiles * slices, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t task = begin; task < end; ++task) {
      const std::int64_t row = task / slices * tile_rows;
      const auto column = static_cast<std::int32_t>(task % slices) * step;
      run_slice(
          kernel, side, weights,
          {row, std::min(rows, row + tile_rows), column, std::min(weights.columns, column + step)},
          epilogue);
    }
  });
}

}  // namespace

void convolve(const KernelMap& map, const MapRows& rows, const float* input, const float* weight,
              std::int32_t in_channels, std::int32_t out_channels, float* output,
              const Epilogue& epilogue, int threads) {
  const KernelTable kernel = internal::kernel_table();
  const PackedWeights weights = pack_all(
      kernel, {weight, out_channels, 1, in_channels, out_channels}, map.elements(), threads);
  run_tiles(kernel,
            {map.inputs, map.outputs, rows.inputs, rows.outputs, map.starts, input, in_channels,
             out_channels, output},
            weights, epilogue, threads);
}

void convolve_input_gradient(const KernelMap& map, const MapRows& rows,
                             const float* gradient_output, const float* weight,
                             std::int32_t in_channels, std::int32_t out_channels,
                             float* gradient_input, int threads) {
  const KernelTable kernel = internal::kernel_table();
  const PackedWeights weights = pack_all(
      kernel, {weight, 1, out_channels, out_channels, in_channels}, map.elements(), threads);
  run_tiles(kernel,
            {map.outputs, map.inputs, rows.outputs, rows.inputs, map.starts, gradient_output,
             out_channels, in_channels, gradient_input},
            weights, {}, threads);
}

}  // namespace arbox::sparse
