#pragma once

#include <benchmark/benchmark.h>
#include <oneapi/dnnl/dnnl.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace arbox::benchmarks {

/// Seconds that `work` takes.
template <class Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// C = A B of n x n matrices by oneDNN, the machine's pace at the moment.
class SgemmPace {
 public:
  double gflops() {
    const double time = seconds([this] {
      dnnl_sgemm('N', 'N', kSize, kSize, kSize, 1.0f, a_.data(), kSize, b_.data(), kSize, 0.0f,
                 c_.data(), kSize);
    });
    return 2.0 * kSize * kSize * kSize / time * 1e-9;
  }

 private:
  static constexpr dnnl_dim_t kSize = 1024;
  std::vector<float> a_ = std::vector<float>(kSize * kSize, 0.5f), b_ = a_, c_ = a_;
};

/// Times `work` (after one warm-up) with one sgemm after every run, and reports medians: `ms`,
/// GFLOP/s of `flop`, those of the sgemm, and the share of the two.
template <class Work>
void time_beside_sgemm(benchmark::State& state, double flop, const Work& work) {
  SgemmPace pace;
  std::vector<double> times, paces;
  work();
  pace.gflops();
  for (auto _ : state) {
    times.push_back(seconds(work));
    state.SetIterationTime(times.back());
    paces.push_back(pace.gflops());
  }
  const double time = median(times), gflops = flop / time * 1e-9;
  state.counters["ms"] = 1e3 * time;
  state.counters["least_ms"] = 1e3 * *std::min_element(times.begin(), times.end());
  if (flop == 0) return;
  state.counters["GFLOPS"] = gflops;
  state.counters["sgemm_GFLOPS"] = median(paces);
  state.counters["share"] = gflops / median(paces);
}

}  // namespace arbox::benchmarks
