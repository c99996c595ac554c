#include <benchmark/benchmark.h>
#include <dnnl.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "arbox/heads/internal/autoregressive_search.h"
#include "heads/random_network.h"

// The paper's box estimator: nine MLPs of (128 + i) -> 128 -> 256 -> 512 -> 1024 -> 512. "products"
// are the products of the hidden layers alone, by oneDNN, of the row counts that sampling without
// equal prefixes has: eight components with a row for each draw and one with a row for each object.
namespace {

using namespace arbox::heads::internal;
using arbox::testing::normal_floats;
using arbox::testing::random_network;

/// A gain of the last layers with which 64 draws of an object have at most 8 different prefixes.
constexpr double kSure = 32.0;
constexpr std::int32_t kFeatures = 128, kBins = 512, kComponents = 9;
const std::vector<std::int32_t> kHidden{128, 256, 512, 1024};

const PackedNetwork& estimator(double gain) {
  static const auto flat =
      random_network(kFeatures, kHidden, std::vector(kComponents, kBins), 1, 1.0).packed();
  static const auto sure =
      random_network(kFeatures, kHidden, std::vector(kComponents, kBins), 1, kSure).packed();
  return gain > 1.0 ? sure : flat;
}

struct Features {
  explicit Features(std::int64_t objects)
      : values(normal_floats(objects * kFeatures, 2, 1.0)), ids(objects) {
    std::iota(ids.begin(), ids.end(), 0);
  }
  FeatureRows rows() const { return {values.data(), std::ssize(ids), kFeatures}; }

  std::vector<float> values;
  std::vector<std::int64_t> ids;
};

void sampling(benchmark::State& state, double gain) {
  const Features features(state.range(0));
  const auto count = static_cast<std::int32_t>(state.range(1));
  const SearchOptions options{.threads = static_cast<int>(state.range(2))};
  const PackedNetwork& network = estimator(gain);
  Vectors draws;
  for (auto _ : state) {
    draws = sample(network, features.rows(), features.ids, 7, count, 1.0, {}, options);
    benchmark::DoNotOptimize(draws);
  }
  // Distinct vectors of the components before the last, an object.
  std::int64_t prefixes = 0, most = 0;
  for (std::int64_t object = 0; object < draws.objects; ++object) {
    std::vector<std::vector<std::int32_t>> seen;
    for (std::int32_t k = 0; k < count; ++k) {
      const auto row = draws.bins.begin() + (object * count + k) * kComponents;
      seen.emplace_back(row, row + kComponents - 1);
    }
    std::sort(seen.begin(), seen.end());
    const std::int64_t distinct = std::unique(seen.begin(), seen.end()) - seen.begin();
    prefixes += distinct;
    most = std::max(most, distinct);
  }
  state.counters["prefixes"] = static_cast<double>(prefixes) / static_cast<double>(draws.objects);
  state.counters["most_prefixes"] = static_cast<double>(most);
}

void beam(benchmark::State& state, double smoothing) {
  const Features features(state.range(0));
  const SearchOptions options{.threads = static_cast<int>(state.range(2))};
  const PackedNetwork& network = estimator(1.0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(beam_search(
        network, features.rows(),
        {.width = static_cast<std::int32_t>(state.range(1)), .smoothing = smoothing}, {}, options));
  }
}

void packing(benchmark::State& state) {
  const auto network = random_network(kFeatures, kHidden, std::vector(kComponents, kBins), 1, 1.0);
  for (auto _ : state) benchmark::DoNotOptimize(network.packed());
}

void products(benchmark::State& state) {
  const std::int64_t objects = state.range(0), rows = objects * state.range(1);
  const auto network = random_network(kFeatures, kHidden, std::vector(kComponents, kBins), 1, 1.0);
  std::vector<float> from(rows * 1024, 0.01f), to(rows * 1024);
  for (auto _ : state) {
    for (const auto& component : network.components) {
      const std::int64_t m = &component == &network.components.front() ? objects : rows;
      for (std::size_t l = 1; l < component.layers.size(); ++l) {
        const LayerWeights& layer = component.layers[l];
        if (dnnl_sgemm('N', 'T', m, layer.out, layer.in, 1.0f, from.data(), layer.in, layer.weight,
                       layer.in, 0.0f, to.data(), layer.out) != dnnl_success) {
          throw std::runtime_error("dnnl_sgemm failed");
        }
        benchmark::DoNotOptimize(to.data());
      }
    }
  }
}

#define ARBOX_TIMED(...) \
  BENCHMARK_CAPTURE(__VA_ARGS__)->Unit(benchmark::kMillisecond)->UseRealTime()
#define ARBOX_TIMED_PLAIN(name) BENCHMARK(name)->Unit(benchmark::kMillisecond)->UseRealTime()

ARBOX_TIMED_PLAIN(products)->Args({15, 64})->Args({15, 50})->Args({1, 64})->Args({100, 64});
ARBOX_TIMED(sampling, random_weights, 1.0)
    ->Args({15, 64, 2})
    ->Args({15, 64, 1})
    ->Args({1, 64, 2})
    ->Args({100, 64, 2});
ARBOX_TIMED(sampling, few_prefixes, kSure)->Args({15, 64, 2})->Args({100, 64, 2});
ARBOX_TIMED(beam, likeliest_bins, 0.0)
    ->Args({15, 50, 2})
    ->Args({15, 50, 1})
    ->Args({15, 1, 2})
    ->Args({1, 50, 2})
    ->Args({1, 1, 2})
    ->Args({100, 50, 2});
ARBOX_TIMED(beam, smoothed, 24.0)->Args({15, 50, 2})->Args({100, 50, 2})->Args({15, 16, 2});
ARBOX_TIMED(sampling, thousand_objects, 1.0)->Args({1000, 64, 2})->Iterations(1);
ARBOX_TIMED_PLAIN(packing);

}  // namespace
