#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/core/ivalue.h>
#include <ATen/ops/elu.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/rand.h>
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <memory>
#include <string>
#include <vector>

#include "arbox/base/parallel.h"
#include "arbox/sparse/layers.h"
#include "arbox/sparse/pooling.h"
#include "arbox/sparse/voxel_sets.h"
#include "sgemm_pace.h"
#include "sparse_clouds.h"

// FCAF3D (Rukhovich et al., ECCV 2022) forward without decoding and NMS: MEResNet3D-34, neck with
// generative upsampling and pruning to 100 000 voxels, heads of 1, 6 and 18 channels. Random
// weights, eval mode, coordinates and kernel maps built anew for each run.
namespace {

using namespace arbox;
using namespace arbox::sparse;
using namespace arbox::benchmarks;

constexpr Kernel kOne{.size = {1, 1, 1}}, kTwoDown{.size = {2, 2, 2}, .stride = {2, 2, 2}},
    kThreeDown{.stride = {2, 2, 2}};

struct Network : torch::nn::Module {
  Network() {
    conv1 = add("conv1", 3, 64, kThreeDown);
    norm1 = register_module("norm1", std::make_shared<InstanceNorm>(64));
    const std::int64_t planes[] = {64, 128, 256, 512}, blocks[] = {3, 4, 6, 3};
    std::int64_t in = 64;
    for (int level = 0; level < 4; ++level) {
      auto& layer = layers.emplace_back();
      for (int b = 0; b < blocks[level]; ++b) {
        layer.push_back(
            register_module("layer" + std::to_string(level + 1) + "_" + std::to_string(b),
                            std::make_shared<ResidualBlock>(in, planes[level], b == 0 ? 2 : 1)));
        in = planes[level];
      }
      const std::string name = std::to_string(level);
      out.push_back(add("out" + name, in, 128, {}));
      out_norm.push_back(add_norm("out_norm" + name, 128));
      if (level == 0) continue;
      const std::int64_t fine = planes[level - 1];
      up.push_back(add("up" + name, in, fine, kTwoDown));
      up_norm.push_back(add_norm("up_norm" + name, fine));
      up_conv.push_back(add("up_conv" + name, fine, fine, {}));
      up_conv_norm.push_back(add_norm("up_conv_norm" + name, fine));
    }
    center = add("center", 128, 1, kOne);
    box = add("box", 128, 6, kOne);
    classes = register_module("classes", std::make_shared<Convolution>(128, 18, kOne, true));
    eval();
  }

  std::shared_ptr<Convolution> add(const std::string& name, std::int64_t in, std::int64_t out_size,
                                   const Kernel& kernel) {
    return register_module(name, std::make_shared<Convolution>(in, out_size, kernel));
  }
  std::shared_ptr<VoxelBatchNorm> add_norm(const std::string& name, std::int64_t channels) {
    return register_module(name, std::make_shared<VoxelBatchNorm>(channels));
  }

  std::shared_ptr<Convolution> conv1, center, box, classes;
  std::shared_ptr<InstanceNorm> norm1;
  std::vector<std::vector<std::shared_ptr<ResidualBlock>>> layers;
  std::vector<std::shared_ptr<Convolution>> out, up, up_conv;
  std::vector<std::shared_ptr<VoxelBatchNorm>> out_norm, up_norm, up_conv_norm;
};

/// Floating-point operations of the convolutions run so far.
struct Work {
  double flop = 0;
  void count(const Connection& connection, const Convolution& layer) {
    const at::Tensor& weight = layer.weight();
    flop += 2.0 * static_cast<double>(connection.map->pairs()) *
            static_cast<double>(weight.size(-1) * weight.size(-2));
  }
};

SparseTensor conv_norm_elu(const Convolution& conv, const VoxelBatchNorm& norm,
                           const SparseTensor& input, Work& work) {
  const auto [scale, shift] = norm.folded();
  const SparseTensor output = conv.forward_fused(input, {.scale = scale, .shift = shift});
  work.count(input.manager().convolution(input.set(), {}), conv);
  at::Tensor features = output.features();
  at::elu_(features);
  return output;
}

SparseTensor up_norm_elu(const Convolution& conv, const VoxelBatchNorm& norm,
                         const SparseTensor& input, Work& work) {
  const auto [scale, shift] = norm.folded();
  const SparseTensor output = conv.generate_fused(input, {.scale = scale, .shift = shift});
  work.count(input.manager().generative(input.set(), kTwoDown), conv);
  at::Tensor features = output.features();
  at::elu_(features);
  return output;
}

SparseTensor residual(ResidualBlock& block, const SparseTensor& input, Work& work) {
  const SparseTensor output = block.forward(input);
  CoordinateManager& manager = input.manager();
  const auto parameters = block.named_parameters();
  const auto count = [&](const char* name, const Connection& connection) {
    const at::Tensor* weight = parameters.find(name);
    if (weight == nullptr) return;
    work.flop += 2.0 * static_cast<double>(connection.map->pairs()) *
                 static_cast<double>(weight->size(-1) * weight->size(-2));
  };
  const bool down = output.set() != input.set();
  count("conv1.kernel", manager.convolution(input.set(), down ? kThreeDown : Kernel{}));
  count("conv2.kernel", manager.convolution(output.set(), {}));
  if (down) {
    count("downsample.0.kernel",
          manager.convolution(input.set(), {.size = {1, 1, 1}, .stride = {2, 2, 2}}));
  }
  return output;
}

struct Result {
  double backbone_seconds = 0, flop = 0;
  std::int64_t finest_voxels = 0;
};

Result forward(Network& net, const at::Tensor& coordinates, const at::Tensor& features) {
  Result result;
  Work work;
  std::vector<SparseTensor> levels;
  result.backbone_seconds = seconds([&] {
    const SparseTensor input(coordinates, features);
    SparseTensor x = net.norm1->forward(net.conv1->forward_fused(input, {}));
    work.count(input.manager().convolution(input.set(), kThreeDown), *net.conv1);
    x = max_pool(relu(x), kTwoDown);
    for (const auto& layer : net.layers) {
      for (const auto& block : layer) x = residual(*block, x, work);
      levels.push_back(x);
    }
  });
  SparseTensor x = levels[3];
  std::unique_ptr<SparseTensor> scores;
  for (int level = 3; level >= 0; --level) {
    if (level < 3) {
      x = up_norm_elu(*net.up[level], *net.up_norm[level], x, work);
      x = conv_norm_elu(*net.up_conv[level], *net.up_conv_norm[level], x, work);
      x = add(levels[level], x);
      const at::Tensor score = interpolate(*scores, x.coordinates()).select(1, 0);
      x = prune(x, highest_in_each_scene(x, score, 100000));
    }
    const SparseTensor out = conv_norm_elu(*net.out[level], *net.out_norm[level], x, work);
    const SparseTensor logits = net.classes->forward_fused(out, {});
    benchmark::DoNotOptimize(net.center->forward_fused(out, {}).features());
    benchmark::DoNotOptimize(net.box->forward_fused(out, {}).features());
    work.flop += 2.0 * static_cast<double>(out.size()) * 128 * 25;
    scores = std::make_unique<SparseTensor>(logits.with_features(logits.features().amax(1, true)));
    result.finest_voxels = out.size();
  }
  result.flop = work.flop;
  return result;
}

void network(benchmark::State& state, int every, int threads) {
  set_default_threads(threads);
  at::set_num_threads(threads);
  const at::NoGradGuard no_gradient;
  std::vector<Coordinate> all = scannet_voxels(), voxels;
  if (all.empty()) all = room_voxels(80000);
  for (std::size_t i = 0; i < all.size(); i += every) voxels.push_back(all[i]);
  const at::Tensor coordinates = to_tensor(voxels);
  const at::Tensor features = at::rand({coordinates.size(0), 3});
  Network net;
  std::int64_t parameters = 4;  // the learnable scale of each level
  for (const at::Tensor& parameter : net.parameters()) parameters += parameter.numel();
  Result result = forward(net, coordinates, features);
  std::vector<double> backbone;
  time_beside_sgemm(state, result.flop, [&] {
    result = forward(net, coordinates, features);
    backbone.push_back(result.backbone_seconds);
  });
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["voxels"] = static_cast<double>(voxels.size());
  state.counters["parameters"] = static_cast<double>(parameters);
  state.counters["GFLOP"] = result.flop * 1e-9;
  state.counters["backbone_ms"] = 1e3 * median(backbone);
  state.counters["finest_voxels"] = static_cast<double>(result.finest_voxels);
  state.counters["peak_MB"] = static_cast<double>(usage.ru_maxrss) / 1024;
}

BENCHMARK_CAPTURE(network, half_the_points_2_threads, 2, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(3);
BENCHMARK_CAPTURE(network, all_points_2_threads, 1, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(3);
BENCHMARK_CAPTURE(network, half_the_points_1_thread, 2, 1)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(2);

}  // namespace
