#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/training/adam_w.h"
#include "arbox/training/one_cycle.h"
#include "arbox/training/weight_average.h"

namespace {

using namespace arbox;
using namespace arbox::training;

TEST(OneCycle, HasTheEndsOfTheReference) {
  const OneCycleOptions options;
  EXPECT_DOUBLE_EQ(one_cycle(options, 0, 1000).learning_rate, 0.001);
  EXPECT_DOUBLE_EQ(one_cycle(options, 0, 1000).momentum, 0.95);
  EXPECT_DOUBLE_EQ(one_cycle(options, 400, 1000).learning_rate, 0.01);
  EXPECT_DOUBLE_EQ(one_cycle(options, 400, 1000).momentum, 0.85);
  EXPECT_NEAR(one_cycle(options, 1000, 1000).learning_rate, 1e-7, 1e-15);
  EXPECT_DOUBLE_EQ(one_cycle(options, 5000, 1000).momentum, 0.95);
  // Halfway up and halfway down a cosine is the mean of its ends.
  EXPECT_NEAR(one_cycle(options, 200, 1000).learning_rate, (0.001 + 0.01) / 2, 1e-12);
  EXPECT_NEAR(one_cycle(options, 700, 1000).learning_rate, (0.01 + 1e-7) / 2, 1e-12);
  EXPECT_NEAR(one_cycle(options, 100, 1000).learning_rate,
              0.01 + (0.001 - 0.01) / 2 * (std::cos(std::numbers::pi / 4) + 1), 1e-12);
}

TEST(OneCycle, RunsOfFewStepsAreDefined) {
  for (std::int64_t steps = 1; steps < 5; ++steps) {
    for (std::int64_t step = 0; step < steps; ++step) {
      const CyclePoint point = one_cycle({}, step, steps);
      EXPECT_GT(point.learning_rate, 0) << step << " of " << steps;
      EXPECT_LE(point.learning_rate, 0.01);
    }
  }
}

/// Adam with decoupled decay as the paper states it, one tensor at a time.
struct PlainAdamW {
  at::Tensor value, first, second;

  void step(const at::Tensor& gradient, const CyclePoint& point, const AdamWOptions& options,
            int number) {
    first = point.momentum * first + (1 - point.momentum) * gradient;
    second = options.beta2 * second + (1 - options.beta2) * gradient.square();
    const at::Tensor mean = first / (1 - std::pow(point.momentum, number));
    const at::Tensor square = second / (1 - std::pow(options.beta2, number));
    value = value * (1 - point.learning_rate * options.weight_decay) -
            point.learning_rate * mean / (square.sqrt() + options.epsilon);
  }
};

TEST(AdamW, EqualsItsFormulas) {
  for (const auto type : {at::kFloat, at::kDouble}) {
    at::manual_seed(1);
    std::vector<at::Tensor> parameters;
    std::vector<PlainAdamW> plain;
    for (const auto& shape : std::vector<std::vector<std::int64_t>>{{3, 5}, {70000}, {}, {0}}) {
      parameters.push_back(at::randn(shape, type).set_requires_grad(true));
      const at::Tensor zero = at::zeros(shape, type);
      plain.push_back({parameters.back().detach().clone(), zero, zero});
    }
    const AdamWOptions options;
    AdamW optimizer(parameters, options);
    for (int step = 1; step <= 6; ++step) {
      const CyclePoint point = one_cycle({}, step, 8);
      for (std::size_t i = 0; i < parameters.size(); ++i) {
        const bool absent = i == 0 && step == 3;
        const at::Tensor gradient =
            absent ? at::zeros_like(plain[i].value) : at::randn(plain[i].value.sizes(), type);
        plain[i].step(gradient * 0.5, point, options, step);
        // A gradient of another layout than its parameter.
        const bool turned = i == 0 && step == 2;
        parameters[i].mutable_grad() = absent   ? at::Tensor()
                                       : turned ? gradient.t().contiguous().t()
                                                : gradient;
      }
      optimizer.step(point, 0.5);
    }
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      EXPECT_TRUE(
          parameters[i].detach().allclose(plain[i].value, 1e-5, type == at::kFloat ? 1e-6 : 1e-12))
          << i;
    }
    EXPECT_EQ(optimizer.steps(), 6);
  }
}

TEST(AdamW, GradientNormAndStepAreTheSameAtAnyThreadCount) {
  const int before = default_threads();
  std::vector<at::Tensor> values;
  std::vector<double> norms;
  for (const int threads : {1, 2, 3}) {
    set_default_threads(threads);
    at::manual_seed(7);
    at::Tensor parameter = at::randn({300000}).set_requires_grad(true);
    parameter.mutable_grad() = at::randn({300000});
    AdamW optimizer({parameter}, {});
    norms.push_back(optimizer.gradient_norm());
    optimizer.step({0.01, 0.9});
    values.push_back(parameter.detach());
    EXPECT_NEAR(norms.back(), parameter.grad().norm().item<double>(), 1e-2);
  }
  set_default_threads(before);
  EXPECT_EQ(norms[0], norms[1]);
  EXPECT_EQ(norms[0], norms[2]);
  EXPECT_TRUE(values[0].equal(values[1]));
  EXPECT_TRUE(values[0].equal(values[2]));
}

TEST(AdamW, RefusesOtherTensors) {
  EXPECT_THROW(AdamW({at::zeros({2}, at::kLong)}, {}), InvalidArgument);
  EXPECT_THROW(AdamW({at::zeros({2, 3}).t()}, {}), InvalidArgument);
}

TEST(WeightAverage, ForgetsTheBeginningAndSwapsBack) {
  at::Tensor weight = at::zeros({50000}).set_requires_grad(true);
  WeightAverage average({weight}, 0.9);
  double expected = 0;
  for (int step = 1; step <= 200; ++step) {
    const at::NoGradGuard no_gradient;
    weight.fill_(step);
    average.update(step);
    const double decay = std::min(0.9, (1.0 + step) / (10.0 + step));
    expected = decay * expected + (1 - decay) * step;
  }
  EXPECT_NEAR(average.values()[0][49999].item<double>(), expected, 1e-3);
  average.swap();
  EXPECT_NEAR(weight[0].item<double>(), expected, 1e-3);
  average.swap();
  EXPECT_EQ(weight[0].item<float>(), 200);
}

}  // namespace
