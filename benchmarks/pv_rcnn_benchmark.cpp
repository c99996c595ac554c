// Times of PV-RCNN at both sizes on a KITTI scan below ARBOX_DATA, with 1 and 2 threads, and of
// training the compact one on simulated streets. Weights are untrained: times do not depend on them
// beyond the number of proposals, which is at its limit here.
//
// Peak memory is the process's: run one benchmark at a time with --benchmark_filter.

#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "arbox/base/options.h"
#include "arbox/base/parallel.h"
#include "arbox/base/random.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/pv_rcnn.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/training/adam_w.h"
#include "arbox/training/pv_rcnn_trainee.h"
#include "arbox/training/street_source.h"
#include "sgemm_pace.h"

namespace arbox::benchmarks {
namespace {

using namespace detectors::pv_rcnn;
using Clock = std::chrono::steady_clock;

constexpr std::int64_t kTrainedRegions = 128;
constexpr std::size_t kMany = 10'000'000;

/// 123 398 points, all around.
const geometry::PointCloud& scan() {
  static const geometry::PointCloud cloud = [] {
    const char* data = std::getenv("ARBOX_DATA");
    if (data == nullptr) return geometry::PointCloud{};
    return io::read_point_cloud(std::string(data) + "/kitti/training/velodyne/000008.bin").points;
  }();
  return cloud;
}

/// The scan again and again, each time with other noise of up to half a metre.
geometry::PointCloud many_points() {
  geometry::PointCloud cloud{.channels = scan().channels, .values = {}};
  const std::size_t columns = scan().columns();
  cloud.values.reserve(kMany * columns);
  const RandomStream random(1, 0, 1);
  for (std::uint32_t i = 0; cloud.values.size() < kMany * columns; ++i) {
    const float value = scan().values[i % scan().values.size()];
    const bool is_place = i % columns < 3;
    cloud.values.push_back(is_place ? value + static_cast<float>(random.uniform(i, -0.5, 0.5))
                                    : value);
  }
  return cloud;
}

/// Milliseconds by stage, one entry a run.
class StageTimes {
 public:
  template <class Work>
  auto time(const char* stage, const Work& work) {
    const auto start = Clock::now();
    auto result = work();
    add(stage, start);
    return result;
  }
  void add(const char* stage, Clock::time_point start) {
    times_[stage].push_back(1e3 * std::chrono::duration<double>(Clock::now() - start).count());
  }
  void report(benchmark::State& state) const {
    for (const auto& [stage, times] : times_) state.counters[stage] = median(times);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    state.counters["peak_MB"] = static_cast<double>(usage.ru_maxrss) / 1024;
  }

 private:
  std::map<std::string, std::vector<double>> times_;
};

Options options_of(const char* name) {
  return read_options<Options>(std::string(ARBOX_CONFIGS) + "/" + name + ".yaml");
}

std::shared_ptr<Network> network_of(const char* name) {
  at::manual_seed(1);
  return std::make_shared<Network>(options_of(name));
}

/// The number of threads that a benchmark's argument names, for all that it does.
ThreadScope threads_of(const benchmark::State& state) {
  at::get_num_threads();  // LibTorch's own choice would come later and undo this one.
  return ThreadScope(static_cast<int>(state.range(0)));
}

bool has_scan(benchmark::State& state) {
  if (scan().size() == 0) state.SkipWithError("needs ARBOX_DATA");
  return scan().size() > 0;
}

void stages(benchmark::State& state, const char* name) {
  if (!has_scan(state)) return;
  const ThreadScope threads = threads_of(state);
  const auto network = network_of(name);
  network->eval();
  const at::NoGradGuard no_gradient;
  const auto view = scan().view();
  const auto pass = [&](StageTimes& times) {
    const auto start = Clock::now();
    const PointBatch batch = times.time("1_voxels", [&] {
      return make_batch({&view, 1}, network->options(), false, 0);
    });
    const FirstStage first = times.time("2_backbones", [&] { return network->first_stage(batch); });
    const Proposals regions = times.time(
        "3_proposals", [&] { return network->propose(first, network->options().proposals); });
    const Keypoints keypoints = times.time("4_keypoints", [&] {
      return network->keypoints(batch, first, regions.boxes, regions.scene);
    });
    benchmark::DoNotOptimize(times.time("5_regions", [&] {
      return network->second_stage(keypoints, regions.boxes, regions.scene);
    }));
    times.add("all", start);
  };
  StageTimes warm_up, times;
  pass(warm_up);
  for (auto _ : state) pass(times);
  times.report(state);
}

void time_detection(benchmark::State& state, const char* name, const geometry::PointCloud& cloud) {
  const PvRcnn detector(network_of(name));
  const detectors::DetectionRequest request{.quantiles = {0.2},
                                            .threads = static_cast<int>(state.range(0))};
  benchmark::DoNotOptimize(detector.detect(cloud.view(), request));
  StageTimes times;
  for (auto _ : state) {
    times.time("ms", [&] { return detector.detect(cloud.view(), request); });
  }
  times.report(state);
}

/// From the cloud to boxes of a beam search, quantile boxes and uncertainty.
void detect(benchmark::State& state, const char* name) {
  if (has_scan(state)) time_detection(state, name, scan());
}

void detect_in_many(benchmark::State& state, const char* name) {
  if (has_scan(state)) time_detection(state, name, many_points());
}

/// Forward and backward of one scan, without targets and optimiser.
void forward_backward(benchmark::State& state, const char* name) {
  if (!has_scan(state)) return;
  const ThreadScope threads = threads_of(state);
  const auto network = network_of(name);
  network->train();
  const auto view = scan().view();
  const auto step = [&](StageTimes& times) {
    const auto start = Clock::now();
    const PointBatch batch = make_batch({&view, 1}, network->options(), true, 1);
    const FirstStage first = network->first_stage(batch);
    const Proposals proposals = network->propose(first, network->options().training_proposals);
    const at::Tensor regions = proposals.boxes.slice(0, 0, kTrainedRegions);
    const at::Tensor scene = proposals.scene.slice(0, 0, kTrainedRegions);
    const Keypoints keypoints = network->keypoints(batch, first, regions, scene);
    const SecondStage second = network->second_stage(keypoints, regions, scene);
    const auto head =
        network->head().loss(network->head_input(second, regions), to_box_rows(regions));
    const at::Tensor loss = first.scores.square().mean() + first.residuals.square().mean() +
                            first.directions.square().mean() + keypoints.logits.square().mean() +
                            second.confidence.square().mean() + second.residuals.square().mean() +
                            head.per_object.mean();
    times.add("1_forward", start);
    const auto middle = Clock::now();
    loss.backward();
    times.add("2_backward", middle);
    times.add("all", start);
    network->zero_grad();
  };
  StageTimes warm_up, times;
  step(warm_up);
  for (auto _ : state) step(times);
  times.report(state);
}

/// Whole steps of training on two simulated scans, as configs/train_compact_street.yaml has them.
void training_step(benchmark::State& state, const char* name) {
  const ThreadScope threads = threads_of(state);
  at::manual_seed(1);
  training::PvRcnnTraineeOptions options;
  options.network = options_of(name);
  training::PvRcnnTrainee trainee(options);
  trainee.network().train();
  const training::StreetSceneSource streets({}, training::ClassNames(options.network.classes));
  std::vector<training::Scene> scenes;
  for (int i = 0; i < 2; ++i) scenes.push_back(streets.scene(i));
  training::AdamW optimizer(trainee.network().parameters(), {});
  training::Communicator alone;
  const auto step = [&](StageTimes& times) {
    const auto start = Clock::now();
    const auto loss = trainee.loss(scenes, {.number = 0, .seed = 1, .first_scene = 0}, alone);
    times.add("1_forward", start);
    const auto middle = Clock::now();
    loss.total.backward();
    times.add("2_backward", middle);
    const auto last = Clock::now();
    optimizer.step({.learning_rate = 1e-4, .momentum = 0.9});
    optimizer.clear_gradients();
    times.add("3_optimizer", last);
    times.add("all", start);
  };
  StageTimes warm_up, times;
  step(warm_up);
  for (auto _ : state) step(times);
  times.report(state);
  state.SetItemsProcessed(state.iterations() * std::ssize(scenes));
}

void few(benchmark::internal::Benchmark* one) {
  one->Arg(2)->Arg(1)->Iterations(5)->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(stages, kitti, "pv_rcnn_kitti")->Apply(few);
BENCHMARK_CAPTURE(stages, compact, "pv_rcnn_compact")->Apply(few);
BENCHMARK_CAPTURE(detect, kitti, "pv_rcnn_kitti")->Apply(few);
BENCHMARK_CAPTURE(detect, compact, "pv_rcnn_compact")->Apply(few);
BENCHMARK_CAPTURE(detect_in_many, kitti, "pv_rcnn_kitti")->Apply(few);
BENCHMARK_CAPTURE(detect_in_many, compact, "pv_rcnn_compact")->Apply(few);
BENCHMARK_CAPTURE(forward_backward, compact, "pv_rcnn_compact")->Apply(few);
BENCHMARK_CAPTURE(training_step, compact, "pv_rcnn_compact")->Apply(few);

}  // namespace
}  // namespace arbox::benchmarks
