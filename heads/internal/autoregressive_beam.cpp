#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "arbox/base/parallel.h"
#include "arbox/heads/internal/autoregressive_search.h"
#include "arbox/heads/internal/row_smoother.h"
#include "arbox/heads/internal/softmax_row.h"

namespace arbox::heads::internal {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::int32_t kNoBin = -1;

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

/// Logits of every live beam, and the logarithm of the sum of their exponentials; where they were
/// smoothed, log probabilities and 0.
struct BeamLogits {
  AlignedFloats values;
  std::vector<float> normalizers;
  std::int32_t columns = 0;

  const float* row(std::int64_t beam) const { return values.data() + beam * columns; }
};

BeamLogits evaluate(ConditionalNetwork& conditionals, const PackedComponent& component,
                    std::int32_t index, const Beams& beams, double smoothing) {
  BeamLogits logits;
  logits.columns = component.columns();
  logits.values.resize(beams.objects.size() * logits.columns);
  logits.normalizers.resize(beams.objects.size());
  conditionals.evaluate(index, {beams.objects, beams.values}, [&](const LogitBlock& block) {
    SoftmaxRow softmax;
    RowSmoother smoother(smoothing);
    std::copy_n(block.values, block.count * block.columns,
                logits.values.begin() + block.first * block.columns);
    for (std::int64_t r = 0; r < block.count; ++r) {
      softmax.set(block.row(r), block.columns, 1.0);
      float& normalizer = logits.normalizers[block.first + r];
      normalizer = softmax.log_normalizer();
      if (smoothing == 0.0 || !softmax.valid()) continue;
      const std::span<float> row(logits.values.data() + (block.first + r) * block.columns,
                                 component.bins);
      for (float& one : row) one -= normalizer;
      smoother.smooth(row, component.circular);
      normalizer = 0.0f;
    }
  });
  return logits;
}

/// The `width` best continuations of the beams [begin, end), best first. A beam whose logits are
/// not finite has one, without a bin and without probability.
std::vector<Candidate> best_continuations(const Beams& beams, std::int32_t begin, std::int32_t end,
                                          const BeamLogits& logits, std::int32_t bins,
                                          std::int32_t width) {
  std::vector<Candidate> heap;  // the worst kept candidate on top
  const auto offer = [&](const Candidate& candidate) {
    if (std::ssize(heap) == width) {
      if (!better(candidate, heap.front())) return;
      std::pop_heap(heap.begin(), heap.end(), better);
      heap.pop_back();
    }
    heap.push_back(candidate);
    std::push_heap(heap.begin(), heap.end(), better);
  };
  for (std::int32_t beam = begin; beam < end; ++beam) {
    const float* row = logits.row(beam);
    const float base = beams.scores[beam] - logits.normalizers[beam];
    if (!std::isfinite(base)) {
      offer({-kInfinity, beam, kNoBin});
      continue;
    }
    float least = std::ssize(heap) == width ? heap.front().score : -kInfinity;
    for (std::int32_t bin = 0; bin < bins; ++bin) {
      const float score = base + row[bin];
      if (!(score >= least)) continue;  // nor what is not a number
      offer({score, beam, bin});
      if (std::ssize(heap) == width) least = heap.front().score;
    }
  }
  std::sort_heap(heap.begin(), heap.end(), better);
  return heap;
}

Beams extend(const Beams& beams, const std::vector<std::vector<Candidate>>& kept,
             const PackedComponent& component, std::int32_t previous) {
  Beams next;
  next.first.push_back(0);
  for (std::size_t object = 0; object < kept.size(); ++object) {
    for (const Candidate& candidate : kept[object]) {
      const std::int64_t from = std::int64_t{candidate.beam} * previous;
      next.objects.push_back(static_cast<std::int32_t>(object));
      next.scores.push_back(candidate.score);
      next.values.insert(next.values.end(), beams.values.begin() + from,
                         beams.values.begin() + from + previous);
      next.values.push_back(candidate.bin == kNoBin ? kNan : component.value(candidate.bin));
      next.bins.insert(next.bins.end(), beams.bins.begin() + from,
                       beams.bins.begin() + from + previous);
      next.bins.push_back(candidate.bin);
    }
    next.first.push_back(static_cast<std::int32_t>(next.objects.size()));
  }
  return next;
}

Beams start(std::int64_t objects, const KnownPrefix& known) {
  Beams beams;
  beams.objects.resize(objects);
  std::iota(beams.objects.begin(), beams.objects.end(), 0);
  beams.scores.assign(objects, 0.0f);
  beams.values.assign(known.values.begin(), known.values.end());
  beams.bins.assign(objects * known.count, kNoBin);
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

Vectors beam_search(const PackedNetwork& network, const FeatureRows& features,
                    const BeamOptions& beam, const KnownPrefix& known,
                    const SearchOptions& options) {
  const std::int32_t size = network.size(), width = beam.width;
  const std::int64_t rows = features.objects * width;
  Vectors result{.objects = features.objects,
                 .count = width,
                 .components = size,
                 .bins = std::vector<std::int32_t>(rows * size, kNoBin),
                 .values = std::vector<float>(rows * size, kNan),
                 .log_probability = std::vector<float>(rows, -kInfinity)};
  ConditionalNetwork conditionals(network, options.threads);
  for_chunks(features, width, options, [&](std::int64_t first, const FeatureRows& chunk) {
    conditionals.set_features(chunk);
    Beams beams = start(chunk.objects, known.of_objects(first, chunk.objects));
    for (std::int32_t i = known.count; i < size; ++i) {
      const BeamLogits logits = evaluate(conditionals, network[i], i, beams, beam.smoothing);
      std::vector<std::vector<Candidate>> kept(chunk.objects);
      parallel_for(chunk.objects, 1, options.threads, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t object = begin; object < end; ++object) {
          kept[object] = best_continuations(beams, beams.first[object], beams.first[object + 1],
                                            logits, network[i].bins, width);
        }
      });
      beams = extend(beams, kept, network[i], i);
    }
    write(beams, first, result);
  });
  return result;
}

}  // namespace arbox::heads::internal
