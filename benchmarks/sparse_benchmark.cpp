#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <ATen/core/ivalue.h>
#include <ATen/ops/randn.h>
#include <benchmark/benchmark.h>
#include <flann/flann.hpp>

#include <memory>
#include <string>

#include "arbox/base/parallel.h"
#include "arbox/sparse/convolution_map.h"
#include "arbox/sparse/coordinate_manager.h"
#include "arbox/sparse/point_search.h"
#include "arbox/sparse/set_abstraction.h"
#include "hashed_kernel_map.h"
#include "sgemm_pace.h"
#include "sparse_clouds.h"

// Sparse convolution and point-set operations on the clouds of sparse_clouds.h. GFLOP/s are
// 2 x pairs x in x out; every row times one sgemm of oneDNN after each run. The naive version
// gathers the rows of each kernel element, multiplies them by dnnl_sgemm and scatters the result.
namespace {

using namespace arbox;
using namespace arbox::sparse;
using namespace arbox::benchmarks;

void use_threads(int threads) {
  set_default_threads(threads);
  at::set_num_threads(threads);
}

std::vector<Coordinate> made_voxels(const std::string& cloud, std::size_t count) {
  return cloud == "kitti" ? kitti_voxels(count) : room_voxels(count);
}

CoordinateSetPtr made_set(const std::string& cloud, std::size_t count) {
  return std::make_shared<const CoordinateSet>(made_voxels(cloud, count), Lattice{});
}

/// A convolution over a map that is there, with random numbers.
struct Convolution {
  Convolution(Connection connected, std::int32_t in, std::int32_t out)
      : connection(std::move(connected)), in_channels(in), out_channels(out) {
    input = random(connection.inputs->size() * in);
    output = random(connection.outputs->size() * out);
    weight = random(map().elements() * in * out);
  }
  static std::vector<float> random(std::int64_t count) {
    const at::Tensor numbers = at::randn({count});
    return {numbers.data_ptr<float>(), numbers.data_ptr<float>() + count};
  }
  const KernelMap& map() const { return *connection.map; }
  MapRows rows() const {
    return {connection.inputs->sorted().rows, connection.outputs->sorted().rows};
  }
  double flop() const {
    return 2.0 * static_cast<double>(map().pairs()) * in_channels * out_channels;
  }

  void forward() {
    convolve(map(), rows(), input.data(), weight.data(), in_channels, out_channels, output.data());
  }
  void input_gradient() {
    convolve_input_gradient(map(), rows(), output.data(), weight.data(), in_channels, out_channels,
                            input.data());
  }
  void weight_gradient() {
    convolve_weight_gradient(map(), rows(), input.data(), output.data(), in_channels, out_channels,
                             weight.data());
  }
  void naive() {
    std::fill(output.begin(), output.end(), 0.0f);
    for (std::int64_t k = 0; k < map().elements(); ++k) {
      const std::int64_t begin = map().starts[k], count = map().starts[k + 1] - begin;
      gathered.resize(count * in_channels);
      product.resize(count * out_channels);
      for (std::int64_t p = 0; p < count; ++p) {
        std::copy_n(
            input.data() + std::int64_t{rows().inputs[map().inputs[begin + p]]} * in_channels,
            in_channels, gathered.data() + p * in_channels);
      }
      dnnl_sgemm('N', 'N', count, out_channels, in_channels, 1.0f, gathered.data(), in_channels,
                 weight.data() + k * in_channels * out_channels, out_channels, 0.0f, product.data(),
                 out_channels);
      for (std::int64_t p = 0; p < count; ++p) {
        float* to =
            output.data() + std::int64_t{rows().outputs[map().outputs[begin + p]]} * out_channels;
        for (std::int32_t c = 0; c < out_channels; ++c) to[c] += product[p * out_channels + c];
      }
    }
  }

  Connection connection;
  std::int32_t in_channels, out_channels;
  std::vector<float> input, output, weight, gathered, product;
};

enum class Pass { kForward, kInputGradient, kWeightGradient, kNaive };

void convolution(benchmark::State& state, const std::string& cloud, std::size_t count,
                 std::int32_t channels, int threads, Pass pass) {
  use_threads(threads);
  const CoordinateSetPtr set = made_set(cloud, count);
  if (set->size() == 0) return state.SkipWithError("ARBOX_DATA is not set");
  CoordinateManager manager;
  Convolution problem(manager.convolution(set, {}), channels, channels);
  time_beside_sgemm(state, problem.flop(), [&] {
    if (pass == Pass::kForward) problem.forward();
    if (pass == Pass::kInputGradient) problem.input_gradient();
    if (pass == Pass::kWeightGradient) problem.weight_gradient();
    if (pass == Pass::kNaive) problem.naive();
  });
  state.counters["pairs"] = static_cast<double>(problem.map().pairs());
}

void kernel_map(benchmark::State& state, const std::string& cloud, std::size_t count, int threads,
                const Kernel& kernel) {
  use_threads(threads);
  const CoordinateSetPtr set = made_set(cloud, count);
  if (set->size() == 0) return state.SkipWithError("ARBOX_DATA is not set");
  time_beside_sgemm(state, 0, [&] {
    CoordinateManager manager;
    benchmark::DoNotOptimize(manager.convolution(set, kernel));
  });
}

void kernel_map_by_hash(benchmark::State& state, const std::string& cloud, std::size_t count,
                        int threads) {
  use_threads(threads);
  const auto voxels = made_voxels(cloud, count);
  if (voxels.empty()) return state.SkipWithError("ARBOX_DATA is not set");
  KernelMap map;
  time_beside_sgemm(state, 0, [&] { map = hashed_kernel_map(voxels, threads); });
  CoordinateManager manager;
  const auto set = std::make_shared<const CoordinateSet>(voxels, Lattice{});
  if (map.pairs() != manager.convolution(set, {}).map->pairs()) {
    state.SkipWithError("the two maps differ");
  }
}

void insertion(benchmark::State& state, const std::string& cloud, std::size_t count) {
  use_threads(2);
  const auto voxels = made_voxels(cloud, count);
  if (voxels.empty()) return state.SkipWithError("ARBOX_DATA is not set");
  time_beside_sgemm(state, 0, [&] { CoordinateSet(voxels, Lattice{}); });
}

void strided(benchmark::State& state, std::size_t count) {
  use_threads(2);
  CoordinateManager manager;
  Convolution problem(manager.convolution(made_set("room", count), {.stride = {2, 2, 2}}), 64, 64);
  time_beside_sgemm(state, problem.flop(), [&] { problem.forward(); });
  state.counters["outputs"] = static_cast<double>(problem.connection.outputs->size());
  state.counters["pairs"] = static_cast<double>(problem.map().pairs());
}

void generative(benchmark::State& state, bool cached) {
  use_threads(2);
  std::vector<Coordinate> voxels = room_voxels(36248);
  for (Coordinate& c : voxels) c = {c.batch, 2 * c.x, 2 * c.y, 2 * c.z};
  const auto set = std::make_shared<const CoordinateSet>(voxels, Lattice{.stride = {2, 2, 2}});
  const Kernel kernel{.size = {2, 2, 2}, .stride = {2, 2, 2}};
  CoordinateManager manager;
  Convolution problem(manager.generative(set, kernel), 256, 128);
  time_beside_sgemm(state, problem.flop(), [&] {
    if (!cached) {
      CoordinateManager fresh;
      problem.connection = fresh.generative(set, kernel);
    }
    problem.forward();
  });
}

void furthest(benchmark::State& state, std::size_t size) {
  const auto points = kitti_points(8, size);
  time_beside_sgemm(state, 0, [&] { benchmark::DoNotOptimize(furthest_points(points, 2048)); });
}

void balls(benchmark::State& state, float radius, bool with_flann) {
  use_threads(2);
  const auto points = kitti_points(8, 16897);
  std::vector<float> centres;
  for (const std::int32_t index : furthest_points(points, 2048)) {
    centres.insert(centres.end(), points.begin() + 3 * index, points.begin() + 3 * index + 3);
  }
  time_beside_sgemm(state, 0, [&] {
    if (!with_flann) {
      benchmark::DoNotOptimize(ball_query(points, centres, {.radius = radius}));
      return;
    }
    const flann::Matrix<float> data(const_cast<float*>(points.data()), points.size() / 3, 3);
    const flann::Matrix<float> queries(centres.data(), centres.size() / 3, 3);
    flann::Index<flann::L2_Simple<float>> index(data, flann::KDTreeSingleIndexParams(10));
    index.buildIndex();
    std::vector<std::vector<int>> found;
    std::vector<std::vector<float>> distances;
    flann::SearchParams parameters(-1, 0, false);
    parameters.cores = 2;
    index.radiusSearch(queries, found, distances, radius * radius, parameters);
    benchmark::DoNotOptimize(found);
  });
}

void roi_grid_pool(benchmark::State& state) {
  use_threads(2);
  const at::NoGradGuard no_gradient;
  const auto points = kitti_points(8, 16897);
  std::vector<float> keypoints;
  for (const std::int32_t index : furthest_points(points, 2048)) {
    keypoints.insert(keypoints.end(), points.begin() + 3 * index, points.begin() + 3 * index + 3);
  }
  const at::Tensor from = at::from_blob(keypoints.data(), {2048, 3}).clone();
  // 100 regions of 216 points, 4 m wide, around key points.
  const at::Tensor centres = (from.slice(0, 0, 100).unsqueeze(1) + at::randn({100, 216, 3}) * 1.2)
                                 .reshape({-1, 3})
                                 .contiguous();
  SetAbstraction module(128, {{.radius = 0.8f, .samples = 16, .widths = {64, 64}},
                              {.radius = 1.6f, .samples = 16, .widths = {64, 64}}});
  module.eval();
  const at::Tensor features = at::randn({2048, 128});
  time_beside_sgemm(state, 0, [&] {
    benchmark::DoNotOptimize(
        module.forward({.points = from, .features = features, .centres = centres}));
  });
}

template <class... Arguments>
void add(const std::string& name, Arguments... arguments) {
  benchmark::RegisterBenchmark(name.c_str(), arguments...)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Iterations(7);
}

void add_cloud(const std::string& cloud, std::size_t count) {
  const std::string set = cloud + "_" + std::to_string(count) + "/";
  for (const int threads : {1, 2}) {
    const std::string end = "/threads_" + std::to_string(threads);
    add("kernel_map/" + set + "k3" + end, kernel_map, cloud, count, threads, Kernel{});
    add("kernel_map_by_hash/" + set + "k3" + end, kernel_map_by_hash, cloud, count, threads);
    for (const std::int32_t channels : {16, 32, 64, 128}) {
      const std::string name = set + std::to_string(channels) + end;
      add("forward/" + name, convolution, cloud, count, channels, threads, Pass::kForward);
      add("input_gradient/" + name, convolution, cloud, count, channels, threads,
          Pass::kInputGradient);
      add("weight_gradient/" + name, convolution, cloud, count, channels, threads,
          Pass::kWeightGradient);
      add("naive_forward/" + name, convolution, cloud, count, channels, threads, Pass::kNaive);
    }
  }
  add("insertion/" + cloud + "_" + std::to_string(count), insertion, cloud, count);
  add("kernel_map/" + set + "k3_s2/threads_2", kernel_map, cloud, count, 2,
      Kernel{.stride = {2, 2, 2}});
}

const bool registered = [] {
  for (const std::size_t count : {20000, 50000, 100000, 200000}) add_cloud("room", count);
  for (const std::size_t count : {20000, 50000, 200000}) add_cloud("kitti", count);
  for (const std::size_t count : {50000, 200000}) {
    add("stride2_64_64/room_" + std::to_string(count), strided, count);
  }
  add("generative_256_128/map_cached", generative, true);
  add("generative_256_128/with_coordinates_and_map", generative, false);
  add("furthest_points_2048/16897", furthest, std::size_t{16897});
  add("furthest_points_2048/28068", furthest, std::size_t{28068});
  for (const float radius : {0.4f, 0.8f}) {
    const std::string name = radius < 0.5f ? "0.4" : "0.8";
    add("ball_query/own_grid/" + name, balls, radius, false);
    add("ball_query/flann/" + name, balls, radius, true);
  }
  add("roi_grid_pool/100x216", roi_grid_pool);
  return true;
}();

}  // namespace
