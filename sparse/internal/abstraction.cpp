#include "arbox/sparse/internal/abstraction.h"

#include <algorithm>
#include <utility>

#include "arbox/base/parallel.h"
#include "arbox/sparse/internal/kernel_table.h"

namespace arbox::sparse::internal {
namespace {

// Balls whose rows share one product with the weights.
constexpr std::int64_t kBallsAtOnce = 16;

struct PackedLayer {
  std::vector<float> weight;
  const float* shift;
  std::int32_t in_channels, out_channels, columns;
};

/// Rows of numbers, `stride` floats each.
struct Rows {
  std::vector<float> data;
  std::int32_t stride = 0;
  float* row(std::int64_t i) { return data.data() + i * stride; }
};

/// The distinct neighbours of a ball: up to where ball_query pads with the first.
std::int32_t distinct(const std::int64_t* index, std::int32_t samples) {
  std::int32_t count = 1;
  while (count < samples && index[count] != index[0]) ++count;
  return count;
}

void first_layer(const AbstractionProblem& problem, std::int64_t centre, std::int64_t point,
                 float* row) {
  if (point < 0) {
    std::copy_n(problem.first_shift, problem.width, row);
  } else {
    const float* p = problem.points + 3 * point;
    const float* c = problem.centres + 3 * centre;
    const float dx = p[0] - c[0], dy = p[1] - c[1], dz = p[2] - c[2];
    const float* wx = problem.position_weight;
    const float* wy = wx + problem.width;
    const float* wz = wy + problem.width;
    const float* from = problem.projected + point * problem.width;
    const float* shift = problem.first_shift;
    for (std::int32_t i = 0; i < problem.width; ++i) {
      row[i] = from[i] + shift[i] + dx * wx[i] + dy * wy[i] + dz * wz[i];
    }
  }
  for (std::int32_t i = 0; i < problem.width; ++i) row[i] = std::max(row[i], 0.0f);
}

void next_layer(const KernelTable& kernel, const PackedLayer& layer, std::int64_t count, Rows& from,
                Rows& to) {
  to.stride = layer.columns;
  to.data.assign(count * to.stride, 0.0f);
  std::vector<const float*> inputs(count);
  std::vector<float*> outputs(count);
  for (std::int64_t i = 0; i < count; ++i) {
    inputs[i] = from.row(i);
    outputs[i] = to.row(i);
    std::copy_n(layer.shift, layer.out_channels, outputs[i]);
  }
  kernel.accumulate({inputs.data(), outputs.data(), count, layer.weight.data(), layer.in_channels,
                     layer.columns});
  for (float& value : to.data) value = std::max(value, 0.0f);
}

}  // namespace

void abstract_balls(const AbstractionProblem& problem, float* output, int threads) {
  const KernelTable kernel = kernel_table();
  std::vector<PackedLayer> layers;
  std::int32_t channels = problem.width;
  for (const AbstractionLayer& layer : problem.layers) {
    channels = layer.out_channels;
    const std::int32_t columns = kernel.padded(channels);
    std::vector<float> packed(std::int64_t{layer.in_channels} * columns);
    kernel.pack_weight({layer.weight, channels, 1, layer.in_channels, channels}, columns,
                       packed.data());
    layers.push_back({std::move(packed), layer.shift, layer.in_channels, channels, columns});
  }
  parallel_for(problem.centre_count, kBallsAtOnce, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 Rows rows, next;
                 std::vector<std::int64_t> starts = {0};
                 for (std::int64_t c = begin; c < end; ++c) {
                   starts.push_back(starts.back() +
                                    distinct(problem.index + c * problem.samples, problem.samples));
                 }
                 rows.stride = problem.width;
                 rows.data.resize(starts.back() * rows.stride);
                 for (std::int64_t c = begin; c < end; ++c) {
                   const std::int64_t* index = problem.index + c * problem.samples;
                   for (std::int64_t i = starts[c - begin]; i < starts[c - begin + 1]; ++i) {
                     first_layer(problem, c, index[i - starts[c - begin]], rows.row(i));
                   }
                 }
                 for (const PackedLayer& layer : layers) {
                   next_layer(kernel, layer, starts.back(), rows, next);
                   std::swap(rows, next);
                 }
                 for (std::int64_t c = begin; c < end; ++c) {
                   float* best = output + c * channels;
                   std::copy_n(rows.row(starts[c - begin]), channels, best);
                   for (std::int64_t i = starts[c - begin] + 1; i < starts[c - begin + 1]; ++i) {
                     const float* row = rows.row(i);
                     for (std::int32_t k = 0; k < channels; ++k)
                       best[k] = std::max(best[k], row[k]);
                   }
                 }
               });
}

}  // namespace arbox::sparse::internal
