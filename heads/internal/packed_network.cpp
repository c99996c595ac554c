#include "arbox/heads/internal/packed_network.h"

#include <algorithm>

#include "arbox/base/cpu.h"
#include "arbox/base/parallel.h"
#include "arbox/heads/internal/mlp_kernel.h"

namespace arbox::heads::internal {

const MlpKernels& mlp_kernels() {
  static const MlpKernels kernels = [] {
    switch (simd_level()) {
      case SimdLevel::kAvx512:
        return MlpKernels{avx512::panel_columns, avx512::layer, avx512::add_prefix, avx512::largest,
                          avx512::exponentials};
      case SimdLevel::kAvx2:
        return MlpKernels{avx2::panel_columns, avx2::layer, avx2::add_prefix, avx2::largest,
                          avx2::exponentials};
      case SimdLevel::kScalar:
        break;
    }
    return MlpKernels{scalar::panel_columns, scalar::layer, scalar::add_prefix, scalar::largest,
                      scalar::exponentials};
  }();
  return kernels;
}

namespace {

// Logits of the padding: no mass, and no infinities that could become NaN.
constexpr float kNoMass = -1e30f;

std::int32_t padded(std::int32_t columns) {
  return (columns + kColumnBlock - 1) / kColumnBlock * kColumnBlock;
}

/// The first `in` inputs of a layer. Weights are transposed in squares that fit the cache.
PackedLayer pack(const LayerWeights& layer, std::int32_t in, bool logits) {
  constexpr std::int32_t kSquare = 16;
  PackedLayer packed;
  packed.in = in;
  packed.columns = padded(layer.out);
  packed.bias.assign(packed.columns, logits ? kNoMass : 0.0f);
  std::copy_n(layer.bias, layer.out, packed.bias.begin());
  packed.weight.assign(std::int64_t{in} * packed.columns, 0.0f);
  const std::int32_t width = mlp_kernels().panel_columns();
  for (std::int32_t first = 0; first < layer.out; first += width) {
    float* panel = packed.weight.data() + std::int64_t{first} * in;
    const std::int32_t outputs = std::min(width, layer.out - first);
    for (std::int32_t begin = 0; begin < in; begin += kSquare) {
      const std::int32_t end = std::min(in, begin + kSquare);
      for (std::int32_t j = 0; j < outputs; ++j) {
        const float* from = layer.weight + std::int64_t{first + j} * layer.in;
        for (std::int32_t k = begin; k < end; ++k) panel[std::int64_t{k} * width + j] = from[k];
      }
    }
  }
  return packed;
}

PackedComponent pack(const ComponentWeights& weights, std::int32_t feature_width) {
  PackedComponent packed;
  packed.bins = weights.bins();
  packed.low = weights.low;
  packed.step = weights.step;
  packed.circular = weights.circular;
  const LayerWeights& first = weights.layers.front();
  packed.features = pack(first, feature_width, weights.layers.size() == 1);
  const std::int32_t values = first.in - feature_width;
  packed.prefix.assign(std::int64_t{values} * packed.features.columns, 0.0f);
  for (std::int32_t j = 0; j < values; ++j) {
    for (std::int32_t c = 0; c < first.out; ++c) {
      packed.prefix[std::int64_t{j} * packed.features.columns + c] =
          first.weight[std::int64_t{c} * first.in + feature_width + j];
    }
  }
  for (std::size_t l = 1; l < weights.layers.size(); ++l) {
    packed.rest.push_back(
        pack(weights.layers[l], weights.layers[l].in, l + 1 == weights.layers.size()));
  }
  return packed;
}

}  // namespace

PackedNetwork::PackedNetwork(std::span<const ComponentWeights> components, float leak, int threads)
    : components_(components.size()),
      feature_width_(components.empty() ? 0 : components.front().layers.front().in),
      leak_(leak) {
  const auto count = static_cast<std::int64_t>(components.size());
  parallel_for(count, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      components_[i] = pack(components[i], feature_width_);
    }
  });
  for (const PackedComponent& component : components_) {
    widest_ = std::max(widest_, component.features.columns);
    for (const PackedLayer& layer : component.rest) widest_ = std::max(widest_, layer.columns);
  }
}

}  // namespace arbox::heads::internal
