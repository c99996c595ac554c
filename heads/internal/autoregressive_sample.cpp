#include <algorithm>
#include <cmath>
#include <numeric>

#include "arbox/base/parallel.h"
#include "arbox/base/random.h"
#include "arbox/heads/internal/autoregressive_search.h"

namespace arbox::heads::internal {
namespace {

constexpr std::uint32_t kPurpose = 200;  // and one for each further component

/// Rows of a chunk of objects, with the group of equal prefixes that each belongs to.
struct Prefixes {
  std::vector<std::int32_t> group_of_row;
  std::vector<std::int32_t> object_of_group;
  std::vector<float> values;  // (groups, components so far)
};

/// Splits the groups by the bin that each row drew. Groups stay in the order of their first row.
void extend(Prefixes& prefixes, std::span<const std::int32_t> bins, const ComponentWeights& weights,
            int previous) {
  std::vector<std::int32_t> rows(bins.size());
  std::iota(rows.begin(), rows.end(), 0);
  std::stable_sort(rows.begin(), rows.end(), [&](std::int32_t a, std::int32_t b) {
    const auto& group = prefixes.group_of_row;
    return group[a] != group[b] ? group[a] < group[b] : bins[a] < bins[b];
  });
  Prefixes next;
  next.group_of_row.resize(bins.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::int32_t row = rows[i], group = prefixes.group_of_row[row];
    const bool fresh =
        i == 0 || prefixes.group_of_row[rows[i - 1]] != group || bins[rows[i - 1]] != bins[row];
    if (fresh) {
      next.object_of_group.push_back(prefixes.object_of_group[group]);
      const auto from = prefixes.values.begin() + std::int64_t{group} * previous;
      next.values.insert(next.values.end(), from, from + previous);
      next.values.push_back(static_cast<float>(weights.low + weights.step * bins[row]));
    }
    next.group_of_row[row] = static_cast<std::int32_t>(next.object_of_group.size()) - 1;
  }
  prefixes = std::move(next);
}

/// Cumulative probabilities of softmax(logits / temperature), and the logarithm of the sum of
/// exp(logits).
float accumulate(std::span<const float> logits, double temperature, std::span<float> cumulative) {
  const float top = *std::max_element(logits.begin(), logits.end());
  const float inverse = static_cast<float>(1.0 / temperature);
  float plain = 0.0f, sum = 0.0f;
  for (std::size_t b = 0; b < logits.size(); ++b) {
    cumulative[b] = std::exp((logits[b] - top) * inverse);
    if (temperature != 1.0) plain += std::exp(logits[b] - top);
  }
  for (float& value : cumulative) value = sum += value;
  if (temperature == 1.0) plain = sum;
  return top + std::log(plain);
}

std::int32_t draw(std::span<const float> cumulative, double uniform) {
  const float target = static_cast<float>(uniform * cumulative.back());
  const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), target);
  return static_cast<std::int32_t>(
      std::min<std::ptrdiff_t>(found - cumulative.begin(), std::ssize(cumulative) - 1));
}

struct Chunk {
  FeatureRows features;
  std::span<const std::int64_t> ids;
  std::span<const float> known;
  std::int64_t first_row;
};

Prefixes start(const Chunk& chunk, std::int32_t count, std::int32_t known) {
  Prefixes prefixes;
  prefixes.group_of_row.resize(chunk.features.objects * count);
  for (std::size_t r = 0; r < prefixes.group_of_row.size(); ++r) {
    prefixes.group_of_row[r] = static_cast<std::int32_t>(r / count);
  }
  prefixes.object_of_group.resize(chunk.features.objects);
  std::iota(prefixes.object_of_group.begin(), prefixes.object_of_group.end(), 0);
  prefixes.values.assign(chunk.known.begin(), chunk.known.begin() + chunk.features.objects * known);
  return prefixes;
}

void sample_chunk(ConditionalNetwork& network, std::span<const ComponentWeights> components,
                  const Chunk& chunk, std::uint64_t seed, double temperature, std::int32_t known,
                  int threads, Vectors& result) {
  const std::int32_t count = result.count, width = result.components;
  Prefixes prefixes = start(chunk, count, known);
  const auto rows = static_cast<std::int64_t>(prefixes.group_of_row.size());
  std::vector<std::int32_t> bins(rows);
  for (std::int32_t i = known; i < width; ++i) {
    const std::int32_t size = components[i].bins();
    const auto logits = network.logits(i, {prefixes.object_of_group, prefixes.values});
    const auto groups = static_cast<std::int64_t>(prefixes.object_of_group.size());
    std::vector<float> cumulative(groups * size), normalizer(groups);
    parallel_for(groups, 16, threads, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t g = begin; g < end; ++g) {
        normalizer[g] = accumulate(logits.subspan(g * size, size), temperature,
                                   std::span(cumulative).subspan(g * size, size));
      }
    });
    for (std::int64_t r = 0; r < rows; ++r) {
      const std::int64_t group = prefixes.group_of_row[r];
      const RandomStream random(seed, static_cast<std::uint64_t>(chunk.ids[r / count]),
                                kPurpose + static_cast<std::uint32_t>(i));
      bins[r] = draw(std::span<const float>(cumulative).subspan(group * size, size),
                     random.uniform(static_cast<std::uint32_t>(r % count)));
      const std::int64_t row = chunk.first_row + r;
      result.bins[row * width + i] = bins[r];
      result.values[row * width + i] =
          static_cast<float>(components[i].low + components[i].step * bins[r]);
      result.log_probability[row] += logits[group * size + bins[r]] - normalizer[group];
    }
    if (i + 1 < width) extend(prefixes, bins, components[i], i);
  }
}

}  // namespace

Vectors sample(std::span<const ComponentWeights> components, const FeatureRows& features,
               std::span<const std::int64_t> ids, std::uint64_t seed, std::int32_t count,
               double temperature, const KnownPrefix& known, const SearchOptions& options) {
  const auto width = static_cast<std::int32_t>(components.size());
  Vectors result{.objects = features.objects,
                 .count = count,
                 .components = width,
                 .bins = {},
                 .values = {},
                 .log_probability = {}};
  result.bins.assign(features.objects * count * width, -1);
  result.values.resize(result.bins.size());
  result.log_probability.assign(features.objects * count, 0.0f);
  for (std::int64_t row = 0; row < features.objects * count; ++row) {
    for (std::int32_t i = 0; i < known.count; ++i) {
      result.values[row * width + i] = known.values[row / count * known.count + i];
    }
  }
  ConditionalNetwork network(components, options.leak, options.threads);
  const std::int64_t at_once = std::max<std::int64_t>(1, options.rows_at_once / std::max(count, 1));
  for (std::int64_t first = 0; first < features.objects; first += at_once) {
    const std::int64_t objects = std::min(at_once, features.objects - first);
    const Chunk chunk{{features.values + first * features.width, objects, features.width},
                      ids.subspan(first, objects),
                      known.values.subspan(first * known.count, objects * known.count),
                      first * count};
    network.set_features(chunk.features);
    sample_chunk(network, components, chunk, seed, temperature, known.count, options.threads,
                 result);
  }
  return result;
}

}  // namespace arbox::heads::internal
