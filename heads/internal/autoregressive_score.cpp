#include <algorithm>
#include <cmath>

#include "arbox/heads/internal/autoregressive_search.h"
#include "arbox/heads/internal/softmax_row.h"

namespace arbox::heads::internal {
namespace {

struct Rows {
  std::vector<std::int32_t> objects;
  std::vector<float> prefixes;  // (rows, component)
};

Rows prefix_rows(std::span<const float> values, std::int64_t objects, std::int32_t count,
                 std::int32_t width, std::int32_t component) {
  Rows rows;
  rows.prefixes.reserve(objects * count * component);
  for (std::int64_t row = 0; row < objects * count; ++row) {
    rows.objects.push_back(static_cast<std::int32_t>(row / count));
    const auto from = values.begin() + row * width;
    rows.prefixes.insert(rows.prefixes.end(), from, from + component);
  }
  return rows;
}

std::int32_t bin_of(float value, const PackedComponent& component) {
  const double bin = std::round((value - component.low) / component.step);
  return bin > 0 ? static_cast<std::int32_t>(std::min<double>(bin, component.bins - 1)) : 0;
}

}  // namespace

std::vector<float> log_probability(const PackedNetwork& network, const FeatureRows& features,
                                   std::span<const float> values, std::int32_t count,
                                   const ComponentRange& range, const SearchOptions& options) {
  const std::int32_t width = network.size();
  std::vector<float> result(features.objects * count, 0.0f);
  ConditionalNetwork conditionals(network, options.threads);
  for_chunks(features, count, options, [&](std::int64_t first, const FeatureRows& chunk) {
    conditionals.set_features(chunk);
    const auto vectors = values.subspan(first * count * width, chunk.objects * count * width);
    for (std::int32_t i = range.first; i < range.last; ++i) {
      const Rows rows = prefix_rows(vectors, chunk.objects, count, width, i);
      conditionals.evaluate(i, {rows.objects, rows.prefixes}, [&](const LogitBlock& block) {
        SoftmaxRow softmax;
        for (std::int64_t r = 0; r < block.count; ++r) {
          const std::int64_t row = block.first + r;
          softmax.set(block.row(r), block.columns, 1.0);
          result[first * count + row] +=
              block.row(r)[bin_of(vectors[row * width + i], network[i])] - softmax.log_normalizer();
        }
      });
    }
  });
  return result;
}

}  // namespace arbox::heads::internal
