#include <algorithm>
#include <cmath>

#include "arbox/base/parallel.h"
#include "arbox/heads/internal/autoregressive_search.h"

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

float log_softmax_at(std::span<const float> logits, std::int32_t bin) {
  const float top = *std::max_element(logits.begin(), logits.end());
  float sum = 0.0f;
  for (const float logit : logits) sum += std::exp(logit - top);
  return logits[bin] - top - std::log(sum);
}

}  // namespace

std::vector<float> log_probability(std::span<const ComponentWeights> components,
                                   const FeatureRows& features, std::span<const float> values,
                                   std::int32_t count, std::int32_t known,
                                   const SearchOptions& options) {
  const auto width = static_cast<std::int32_t>(components.size());
  std::vector<float> result(features.objects * count, 0.0f);
  ConditionalNetwork network(components, options.leak, options.threads);
  const std::int64_t at_once = std::max<std::int64_t>(1, options.rows_at_once / std::max(count, 1));
  for (std::int64_t first = 0; first < features.objects; first += at_once) {
    const std::int64_t objects = std::min(at_once, features.objects - first);
    network.set_features({features.values + first * features.width, objects, features.width});
    const auto chunk = values.subspan(first * count * width, objects * count * width);
    for (std::int32_t i = known; i < width; ++i) {
      const Rows rows = prefix_rows(chunk, objects, count, width, i);
      const std::int32_t bins = components[i].bins();
      const auto logits = network.logits(i, {rows.objects, rows.prefixes});
      parallel_for(objects * count, 64, options.threads, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t row = begin; row < end; ++row) {
          const double bin = (chunk[row * width + i] - components[i].low) / components[i].step;
          const auto index = std::clamp(static_cast<std::int32_t>(std::lround(bin)), 0, bins - 1);
          result[first * count + row] += log_softmax_at(logits.subspan(row * bins, bins), index);
        }
      });
    }
  }
  return result;
}

}  // namespace arbox::heads::internal
