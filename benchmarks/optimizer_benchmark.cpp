// A step of AdamW over 5 million parameters in tensors such as detectors have, against the same
// formulas as one ATen operation after the other, tensor by tensor.
#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/zeros_like.h>
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "arbox/base/parallel.h"
#include "arbox/training/adam_w.h"

namespace {

using arbox::training::AdamW;
using arbox::training::AdamWOptions;
using arbox::training::CyclePoint;

constexpr CyclePoint kPoint{0.005, 0.9};

/// 5.0 million parameters: convolutions with two vectors each, as of their batch norms.
std::vector<at::Tensor> made_parameters() {
  std::vector<at::Tensor> parameters;
  const auto add = [&](std::vector<std::int64_t> shape) {
    parameters.push_back(at::randn(shape).set_requires_grad(true));
    parameters.back().mutable_grad() = at::randn(shape);
  };
  for (const std::int64_t channels : {16, 32, 64, 64, 128, 128, 256}) {
    for (int layer = 0; layer < 4; ++layer) {
      add({channels, 3, 3, 1 + (channels < 128 ? 2 : 0), channels});
      add({channels});
      add({channels});
    }
  }
  std::int64_t total = 0;
  for (const at::Tensor& parameter : parameters) total += parameter.numel();
  add({5000000 - total});
  return parameters;
}

void set_threads(benchmark::State& state) {
  arbox::set_default_threads(static_cast<int>(state.range(0)));
  at::set_num_threads(static_cast<int>(state.range(0)));
}

void fused(benchmark::State& state) {
  set_threads(state);
  AdamW optimizer(made_parameters(), {});
  for (auto _ : state) {
    const double norm = optimizer.gradient_norm();
    optimizer.step(kPoint, std::min(1.0, 10 / norm));
  }
}

void tensor_by_tensor(benchmark::State& state) {
  set_threads(state);
  const at::NoGradGuard no_gradient;
  const AdamWOptions options;
  std::vector<at::Tensor> parameters = made_parameters(), first, second;
  for (const at::Tensor& parameter : parameters) {
    first.push_back(at::zeros_like(parameter));
    second.push_back(at::zeros_like(parameter));
  }
  int step = 0;
  for (auto _ : state) {
    ++step;
    double squares = 0;
    for (const at::Tensor& parameter : parameters) {
      squares += std::pow(parameter.grad().norm().item<double>(), 2);
    }
    const double scale = std::min(1.0, 10 / std::sqrt(squares));
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const at::Tensor gradient = parameters[i].grad() * scale;
      parameters[i].mul_(1 - kPoint.learning_rate * options.weight_decay);
      first[i].mul_(kPoint.momentum).add_(gradient, 1 - kPoint.momentum);
      second[i].mul_(options.beta2).addcmul_(gradient, gradient, 1 - options.beta2);
      const at::Tensor root =
          (second[i] / (1 - std::pow(options.beta2, step))).sqrt_().add_(options.epsilon);
      parameters[i].addcdiv_(first[i], root,
                             -kPoint.learning_rate / (1 - std::pow(kPoint.momentum, step)));
    }
  }
}

BENCHMARK(fused)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(tensor_by_tensor)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
