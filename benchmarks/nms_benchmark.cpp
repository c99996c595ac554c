#include <benchmark/benchmark.h>

#include <random>

#include "support/nms_cases.h"

// Clustered: 16 places; spread: anywhere in 70 m x 70 m. The naive version tests every pair of a
// kept box and a later one with the same overlap.
namespace {

using namespace arbox::geometry;
using namespace arbox::testing;

void run(benchmark::State& state, int count, int clusters, const NmsOptions& options) {
  std::mt19937_64 random(1);
  const auto input = proposals(random, count, clusters);
  NmsResult result;
  for (auto _ : state) {
    result = nms(input.boxes, input.scores, options);
    benchmark::DoNotOptimize(result);
  }
  state.counters["kept"] = static_cast<double>(result.kept.size());
}

void naive(benchmark::State& state, int count, int clusters, double threshold, OverlapSpace space) {
  std::mt19937_64 random(1);
  const auto input = proposals(random, count, clusters);
  std::vector<std::int64_t> result;
  for (auto _ : state) {
    result = naive_nms(input, threshold, space);
    benchmark::DoNotOptimize(result);
  }
  state.counters["kept"] = static_cast<double>(result.size());
}

NmsOptions at(double threshold, int threads = 0) {
  return {.threshold = threshold, .threads = threads};
}

#define ARBOX_TIMED(function, name, ...) \
  BENCHMARK_CAPTURE(function, name, __VA_ARGS__)->Unit(benchmark::kMillisecond)->UseRealTime()

ARBOX_TIMED(run, clustered_5000_at_0_1, 5000, 16, at(0.1));
ARBOX_TIMED(run, clustered_5000_at_0_7, 5000, 16, at(0.7));
ARBOX_TIMED(run, spread_5000_at_0_1, 5000, 5000, at(0.1));
ARBOX_TIMED(run, clustered_1000_at_0_1, 1000, 16, at(0.1));
ARBOX_TIMED(run, clustered_1000_at_0_7, 1000, 16, at(0.7));
ARBOX_TIMED(run, one_thread_clustered_5000_at_0_1, 5000, 16, at(0.1, 1));
ARBOX_TIMED(run, one_thread_clustered_5000_at_0_7, 5000, 16, at(0.7, 1));
ARBOX_TIMED(run, full_3d_clustered_5000_at_0_1, 5000, 16,
            NmsOptions{.threshold = 0.1, .space = "3d"});
ARBOX_TIMED(run, soft_gaussian_clustered_5000, 5000, 16,
            NmsOptions{.minimum_score = 0.01, .soft = "gaussian"});
ARBOX_TIMED(naive, clustered_5000_at_0_1, 5000, 16, 0.1, OverlapSpace::kBirdsEye);
ARBOX_TIMED(naive, clustered_5000_at_0_7, 5000, 16, 0.7, OverlapSpace::kBirdsEye);
ARBOX_TIMED(naive, spread_5000_at_0_1, 5000, 5000, 0.1, OverlapSpace::kBirdsEye);

}  // namespace
