#include <algorithm>
#include <limits>
#include <numeric>

#include "arbox/base/random.h"
#include "arbox/heads/internal/autoregressive_search.h"
#include "arbox/heads/internal/softmax_row.h"

namespace arbox::heads::internal {
namespace {

constexpr std::uint32_t kPurpose = 200;  // and one for each further component
constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

/// The draws (rows) of a chunk of objects in groups of equal prefixes, object by object.
struct Groups {
  std::vector<std::int32_t> objects;  // by group
  std::vector<float> values;          // (groups, components so far)
  std::vector<std::int32_t> rows;     // those of one group stand together
  std::vector<std::int64_t> first;    // by group, one more at the end

  std::span<const std::int32_t> rows_of(std::int64_t group) const {
    return std::span(rows).subspan(first[group], first[group + 1] - first[group]);
  }
};

Groups start(std::int64_t objects, std::int32_t count, const KnownPrefix& known) {
  Groups groups;
  groups.objects.resize(objects);
  std::iota(groups.objects.begin(), groups.objects.end(), 0);
  groups.values.assign(known.values.begin(), known.values.end());
  groups.rows.resize(objects * count);
  std::iota(groups.rows.begin(), groups.rows.end(), 0);
  for (std::int64_t object = 0; object <= objects; ++object) groups.first.push_back(object * count);
  return groups;
}

/// Splits the groups by the bin that each row drew. `values` (rows, stride): component i of row r
/// is at r * stride + i.
Groups split(const Groups& groups, std::span<const std::int32_t> bins,
             std::span<const float> values, std::int32_t stride, std::int32_t component) {
  Groups next;
  next.rows = groups.rows;
  for (std::size_t group = 0; group < groups.objects.size(); ++group) {
    const std::int64_t begin = groups.first[group], end = groups.first[group + 1];
    const auto bin = [&](std::int32_t row) { return bins[row * std::int64_t{stride} + component]; };
    std::sort(
        next.rows.begin() + begin, next.rows.begin() + end,
        [&](std::int32_t a, std::int32_t b) { return bin(a) != bin(b) ? bin(a) < bin(b) : a < b; });
    for (std::int64_t i = begin; i < end; ++i) {
      if (i > begin && bin(next.rows[i]) == bin(next.rows[i - 1])) continue;
      next.first.push_back(i);
      next.objects.push_back(groups.objects[group]);
      const auto from = values.begin() + next.rows[i] * std::int64_t{stride};
      next.values.insert(next.values.end(), from, from + component + 1);
    }
  }
  next.first.push_back(static_cast<std::int64_t>(next.rows.size()));
  return next;
}

/// What a chunk of objects reads and writes; rows count from the chunk's first one.
struct Chunk {
  std::span<const std::int64_t> ids;
  std::uint64_t seed;
  double temperature;
  std::int32_t count, width;
  std::span<std::int32_t> bins;
  std::span<float> values, log_probability;

  void draw(const SoftmaxRow& softmax, const PackedComponent& component, std::int32_t i,
            const float* logits, std::span<const std::int32_t> rows) const {
    for (const std::int32_t row : rows) {
      const std::int64_t at = std::int64_t{row} * width + i;
      const RandomStream random(seed, static_cast<std::uint64_t>(ids[row / count]),
                                kPurpose + static_cast<std::uint32_t>(i));
      const auto index = static_cast<std::uint32_t>(row % count);
      bins[at] = softmax.valid() ? softmax.draw(random.uniform(index)) : 0;
      values[at] = softmax.valid() ? component.value(bins[at]) : kNoValue;
      log_probability[row] += logits[bins[at]] - softmax.log_normalizer();
    }
  }
};

void sample_chunk(ConditionalNetwork& conditionals, const PackedNetwork& network,
                  const KnownPrefix& known, const Chunk& chunk) {
  Groups groups = start(std::ssize(chunk.ids), chunk.count, known);
  for (std::int32_t i = known.count; i < chunk.width; ++i) {
    conditionals.evaluate(i, {groups.objects, groups.values}, [&](const LogitBlock& block) {
      SoftmaxRow softmax;
      for (std::int64_t r = 0; r < block.count; ++r) {
        softmax.set(block.row(r), block.columns, chunk.temperature);
        chunk.draw(softmax, network[i], i, block.row(r), groups.rows_of(block.first + r));
      }
    });
    if (i + 1 < chunk.width) groups = split(groups, chunk.bins, chunk.values, chunk.width, i);
  }
}

}  // namespace

Vectors sample(const PackedNetwork& network, const FeatureRows& features,
               std::span<const std::int64_t> ids, std::uint64_t seed, std::int32_t count,
               double temperature, const KnownPrefix& known, const SearchOptions& options) {
  const std::int32_t width = network.size();
  const std::int64_t rows = features.objects * count;
  Vectors result{.objects = features.objects,
                 .count = count,
                 .components = width,
                 .bins = std::vector<std::int32_t>(rows * width, -1),
                 .values = std::vector<float>(rows * width),
                 .log_probability = std::vector<float>(rows, 0.0f)};
  for (std::int64_t row = 0; row < rows; ++row) {
    std::copy_n(known.values.begin() + row / count * known.count, known.count,
                result.values.begin() + row * width);
  }
  ConditionalNetwork conditionals(network, options.threads);
  for_chunks(features, count, options, [&](std::int64_t first, const FeatureRows& part) {
    const std::int64_t begin = first * count, size = part.objects * count;
    conditionals.set_features(part);
    sample_chunk(conditionals, network, known.of_objects(first, part.objects),
                 {.ids = ids.subspan(first, part.objects),
                  .seed = seed,
                  .temperature = temperature,
                  .count = count,
                  .width = width,
                  .bins = std::span(result.bins).subspan(begin * width, size * width),
                  .values = std::span(result.values).subspan(begin * width, size * width),
                  .log_probability = std::span(result.log_probability).subspan(begin, size)});
  });
  return result;
}

}  // namespace arbox::heads::internal
