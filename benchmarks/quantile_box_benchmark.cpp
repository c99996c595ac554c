#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "arbox/geometry/quantile_box.h"
#include "support/box_samples.h"
#include "support/naive_quantile_box.h"

// Shape of the paper's figure: 15 objects, 64 samples, 64 points each.
namespace {

using namespace arbox::geometry;
using namespace arbox::testing;

constexpr int kSamples = 64;
const std::vector<double> kOne = {0.2};
const std::vector<double> kTwo = {0.2, 0.8};

std::vector<std::vector<Box>> make_objects(int count, double spread, bool yaw_only) {
  std::mt19937_64 random(1);
  std::vector<std::vector<Box>> objects;
  for (int i = 0; i < count; ++i) {
    objects.push_back(scattered_samples(random, kSamples, spread, yaw_only));
  }
  return objects;
}

std::vector<BoxSamples> views(const std::vector<std::vector<Box>>& objects) {
  std::vector<BoxSamples> result;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    result.push_back({.boxes = objects[i], .object = i});
  }
  return result;
}

void run(benchmark::State& state, int count, double spread, bool yaw_only,
         const std::vector<double>& qs, const QuantileOptions& options = {}) {
  const auto objects = make_objects(count, spread, yaw_only);
  const auto input = views(objects);
  for (auto _ : state) benchmark::DoNotOptimize(quantile_boxes(input, qs, options));
  state.counters["objects"] = count;
}

void naive(benchmark::State& state, double spread, bool yaw_only) {
  const auto objects = make_objects(15, spread, yaw_only);
  for (auto _ : state) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
      benchmark::DoNotOptimize(naive_quantile_boxes(objects[i], kOne, 4, 0, i));
    }
  }
  state.counters["objects"] = 15;
}

constexpr double kConcentrated = 0.1;
constexpr double kSpreadOut = 0.7;

BENCHMARK_CAPTURE(run, free_concentrated, 15, kConcentrated, false, kOne)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, free_spread_out, 15, kSpreadOut, false, kOne)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, yaw_concentrated, 15, kConcentrated, true, kOne)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, two_quantiles, 15, kConcentrated, false, kTwo)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, one_thread, 15, kConcentrated, false, kOne, QuantileOptions{.threads = 1})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, refined, 15, kConcentrated, false, kOne, QuantileOptions{.refine = true})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, objects_1, 1, kConcentrated, false, kOne)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, objects_100, 100, kConcentrated, false, kOne)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(run, objects_1000, 1000, kConcentrated, false, kOne)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(naive, free_concentrated, kConcentrated, false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(naive, free_spread_out, kSpreadOut, false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
