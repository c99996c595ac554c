#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "arbox/base/parallel.h"
#include "arbox/heads/internal/autoregressive_search.h"

namespace arbox::heads::internal {
namespace {

struct Candidate {
  float score;
  std::int32_t beam, bin;
};

bool better(const Candidate& a, const Candidate& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.beam != b.beam ? a.beam < b.beam : a.bin < b.bin;
}

/// The live beams of a chunk of objects; those of one object stand together, best first.
struct Beams {
  std::vector<std::int32_t> objects;
  std::vector<float> scores;
  std::vector<float> values;        // (beams, components so far)
  std::vector<std::int32_t> bins;   // (beams, components so far)
  std::vector<std::int32_t> first;  // by object, one more at the end
};

float log_normalizer(std::span<const float> logits) {
  const float top = *std::max_element(logits.begin(), logits.end());
  float sum = 0.0f;
  for (const float logit : logits) sum += std::exp(logit - top);
  return top + std::log(sum);
}

/// The `width` best continuations of the beams [begin, end), best first.
std::vector<Candidate> best_continuations(const Beams& beams, std::int32_t begin, std::int32_t end,
                                          std::span<const float> logits, std::int32_t bins,
                                          std::int32_t width) {
  std::vector<Candidate> heap;  // the worst kept candidate on top
  heap.reserve(width + 1);
  for (std::int32_t beam = begin; beam < end; ++beam) {
    const auto row = logits.subspan(std::int64_t{beam} * bins, bins);
    const float base = beams.scores[beam] - log_normalizer(row);
    for (std::int32_t bin = 0; bin < bins; ++bin) {
      const Candidate candidate{base + row[bin], beam, bin};
      if (std::ssize(heap) == width) {
        if (!better(candidate, heap.front())) continue;
        std::pop_heap(heap.begin(), heap.end(), better);
        heap.pop_back();
      }
      heap.push_back(candidate);
      std::push_heap(heap.begin(), heap.end(), better);
    }
  }
  std::sort_heap(heap.begin(), heap.end(), better);
  return heap;
}

Beams extend(const Beams& beams, const std::vector<std::vector<Candidate>>& kept,
             const ComponentWeights& weights, std::int32_t previous) {
  Beams next;
  next.first.push_back(0);
  for (std::size_t object = 0; object < kept.size(); ++object) {
    for (const Candidate& candidate : kept[object]) {
      const std::int64_t from = std::int64_t{candidate.beam} * previous;
      next.objects.push_back(static_cast<std::int32_t>(object));
      next.scores.push_back(candidate.score);
      next.values.insert(next.values.end(), beams.values.begin() + from,
                         beams.values.begin() + from + previous);
      next.values.push_back(static_cast<float>(weights.low + weights.step * candidate.bin));
      next.bins.insert(next.bins.end(), beams.bins.begin() + from,
                       beams.bins.begin() + from + previous);
      next.bins.push_back(candidate.bin);
    }
    next.first.push_back(static_cast<std::int32_t>(next.objects.size()));
  }
  return next;
}

Beams start(std::int64_t objects, std::span<const float> known, std::int32_t known_count) {
  Beams beams;
  beams.objects.resize(objects);
  std::iota(beams.objects.begin(), beams.objects.end(), 0);
  beams.scores.assign(objects, 0.0f);
  beams.values.assign(known.begin(), known.begin() + objects * known_count);
  beams.bins.assign(objects * known_count, -1);
  beams.first.resize(objects + 1);
  std::iota(beams.first.begin(), beams.first.end(), 0);
  return beams;
}

void write(const Beams& beams, std::int64_t first_object, Vectors& result) {
  const std::int32_t width = result.components;
  for (std::size_t object = 0; object + 1 < beams.first.size(); ++object) {
    for (std::int32_t beam = beams.first[object]; beam < beams.first[object + 1]; ++beam) {
      const std::int64_t row = (first_object + static_cast<std::int64_t>(object)) * result.count +
                               beam - beams.first[object];
      std::copy_n(beams.bins.begin() + std::int64_t{beam} * width, width,
                  result.bins.begin() + row * width);
      std::copy_n(beams.values.begin() + std::int64_t{beam} * width, width,
                  result.values.begin() + row * width);
      result.log_probability[row] = beams.scores[beam];
    }
  }
}

}  // namespace

Vectors beam_search(std::span<const ComponentWeights> components, const FeatureRows& features,
                    std::int32_t width, const KnownPrefix& known, const SearchOptions& options) {
  const auto size = static_cast<std::int32_t>(components.size());
  Vectors result{.objects = features.objects,
                 .count = width,
                 .components = size,
                 .bins = {},
                 .values = {},
                 .log_probability = {}};
  result.bins.assign(features.objects * width * size, 0);
  result.values.assign(result.bins.size(), 0.0f);
  result.log_probability.assign(features.objects * width, -std::numeric_limits<float>::infinity());
  ConditionalNetwork network(components, options.leak, options.threads);
  const std::int64_t at_once = std::max<std::int64_t>(1, options.rows_at_once / std::max(width, 1));
  for (std::int64_t first = 0; first < features.objects; first += at_once) {
    const std::int64_t objects = std::min(at_once, features.objects - first);
    network.set_features({features.values + first * features.width, objects, features.width});
    Beams beams = start(objects, known.values.subspan(first * known.count, objects * known.count),
                        known.count);
    for (std::int32_t i = known.count; i < size; ++i) {
      const auto logits = network.logits(i, {beams.objects, beams.values});
      std::vector<std::vector<Candidate>> kept(objects);
      parallel_for(objects, 1, options.threads, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t object = begin; object < end; ++object) {
          kept[object] = best_continuations(beams, beams.first[object], beams.first[object + 1],
                                            logits, components[i].bins(), width);
        }
      });
      beams = extend(beams, kept, components[i], i);
    }
    write(beams, first, result);
  }
  return result;
}

}  // namespace arbox::heads::internal
