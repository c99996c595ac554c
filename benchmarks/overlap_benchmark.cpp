#include <benchmark/benchmark.h>

#include "arbox/base/cpu.h"
#include "arbox/geometry/internal/overlap_engine.h"
#include "arbox/geometry/overlap.h"
#include "naive_overlap.h"

namespace {

using namespace arbox;
using geometry::Box;

struct Boxes {
  std::vector<Box> first, second;
};

Boxes spread() { return {benchmarks::spread_cars(1000, 1), benchmarks::spread_cars(1000, 2)}; }
Boxes clustered() {
  return {benchmarks::clustered_proposals(1000, 1), benchmarks::clustered_proposals(1000, 2)};
}
Boxes dense() { return {benchmarks::dense_boxes(500, 1), benchmarks::dense_boxes(500, 2)}; }
Boxes room() {
  return {benchmarks::dense_boxes(500, 1, 6.0), benchmarks::dense_boxes(500, 2, 6.0)};
}

void report(benchmark::State& state, const Boxes& boxes, std::span<const double> overlaps) {
  const double pairs = static_cast<double>(boxes.first.size() * boxes.second.size());
  const auto hits =
      std::count_if(overlaps.begin(), overlaps.end(), [](double x) { return x > 1e-9; });
  state.counters["overlapping_%"] = 100.0 * static_cast<double>(hits) / pairs;
  state.counters["s/pair"] = benchmark::Counter(
      pairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void naive(benchmark::State& state, Boxes (*make)(),
           std::vector<double> (*iou)(std::span<const Box>, std::span<const Box>)) {
  const Boxes boxes = make();
  std::vector<double> result;
  for (auto _ : state) result = iou(boxes.first, boxes.second);
  report(state, boxes, result);
}

void arbox_iou(benchmark::State& state, Boxes (*make)(), geometry::OverlapOptions options) {
  const Boxes boxes = make();
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> result;
  for (auto _ : state) result = geometry::overlap_matrix(boxes.first, boxes.second, options);
  report(state, boxes, {result.data(), static_cast<std::size_t>(result.size())});
}

void at_level(benchmark::State& state, Boxes (*make)(), SimdLevel level) {
  if (level > simd_level()) {
    state.SkipWithError("this CPU lacks the level");
    return;
  }
  const Boxes boxes = make();
  std::vector<double> result(boxes.first.size() * boxes.second.size());
  for (auto _ : state) {
    geometry::internal::overlap_matrix_at(level, boxes.first, boxes.second, {.threads = 1},
                                          result.data());
  }
  report(state, boxes, result);
}

constexpr geometry::OverlapOptions kOne{.threads = 1};
constexpr geometry::OverlapOptions kTwo{.threads = 2};
constexpr geometry::OverlapOptions kBirdsEye{.space = geometry::OverlapSpace::kBirdsEye,
                                             .threads = 1};

#define OVERLAP_BENCHMARK(function, name, ...)   \
  BENCHMARK_CAPTURE(function, name, __VA_ARGS__) \
      ->Unit(benchmark::kMillisecond)            \
      ->UseRealTime()                            \
      ->MinTime(0.3)

OVERLAP_BENCHMARK(naive, yaw_spread, spread, benchmarks::naive_yaw_iou);
OVERLAP_BENCHMARK(arbox_iou, yaw_spread_1_thread, spread, kOne);
OVERLAP_BENCHMARK(arbox_iou, yaw_spread_2_threads, spread, kTwo);
OVERLAP_BENCHMARK(arbox_iou, birds_eye_spread_1_thread, spread, kBirdsEye);
OVERLAP_BENCHMARK(naive, yaw_clustered, clustered, benchmarks::naive_yaw_iou);
OVERLAP_BENCHMARK(arbox_iou, yaw_clustered_1_thread, clustered, kOne);
OVERLAP_BENCHMARK(arbox_iou, yaw_clustered_2_threads, clustered, kTwo);
OVERLAP_BENCHMARK(arbox_iou, birds_eye_clustered_1_thread, clustered, kBirdsEye);
OVERLAP_BENCHMARK(naive, free_dense, dense, benchmarks::naive_free_iou);
OVERLAP_BENCHMARK(arbox_iou, free_dense_1_thread, dense, kOne);
OVERLAP_BENCHMARK(arbox_iou, free_dense_2_threads, dense, kTwo);
OVERLAP_BENCHMARK(naive, free_room, room, benchmarks::naive_free_iou);
OVERLAP_BENCHMARK(arbox_iou, free_room_1_thread, room, kOne);
OVERLAP_BENCHMARK(arbox_iou, free_room_2_threads, room, kTwo);
OVERLAP_BENCHMARK(at_level, yaw_clustered_scalar, clustered, SimdLevel::kScalar);
OVERLAP_BENCHMARK(at_level, yaw_clustered_avx2, clustered, SimdLevel::kAvx2);
OVERLAP_BENCHMARK(at_level, yaw_clustered_avx512, clustered, SimdLevel::kAvx512);
OVERLAP_BENCHMARK(at_level, free_dense_scalar, dense, SimdLevel::kScalar);
OVERLAP_BENCHMARK(at_level, free_dense_avx2, dense, SimdLevel::kAvx2);
OVERLAP_BENCHMARK(at_level, free_dense_avx512, dense, SimdLevel::kAvx512);

}  // namespace
