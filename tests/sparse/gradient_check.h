#pragma once

#include <ATen/core/Tensor.h>
#include <ATen/ops/ones_like.h>
#include <ATen/ops/randn_like.h>
#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

#include <functional>
#include <vector>

namespace arbox::sparse {

/// Compares the gradients of sum(function(inputs) * random) with central differences. Inputs are
/// float64 leaves.
inline void expect_gradients(
    std::vector<at::Tensor> inputs,
    const std::function<at::Tensor(const std::vector<at::Tensor>&)>& function,
    double tolerance = 1e-6) {
  for (at::Tensor& input : inputs) input = input.detach().clone().set_requires_grad(true);
  const at::Tensor output = function(inputs);
  const at::Tensor weights = at::randn_like(output.detach());
  const auto gradients =
      torch::autograd::grad({output}, inputs, {weights}, c10::nullopt, false, true);
  constexpr double kStep = 1e-5;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    ASSERT_TRUE(gradients[k].defined()) << "input " << k;
    const at::Tensor values = inputs[k].detach().view({-1});
    const at::Tensor gradient = gradients[k].contiguous().view({-1});
    const std::int64_t stride = std::max<std::int64_t>(1, values.numel() / 60);
    for (std::int64_t i = 0; i < values.numel(); i += stride) {
      const double before = values[i].item<double>();
      const auto at_value = [&](double value) {
        values[i] = value;
        return (function(inputs).detach() * weights).sum().item<double>();
      };
      const double numerical = (at_value(before + kStep) - at_value(before - kStep)) / (2 * kStep);
      values[i] = before;
      EXPECT_NEAR(gradient[i].item<double>(), numerical, tolerance * (1 + std::abs(numerical)))
          << "input " << k << ", entry " << i;
    }
  }
}

}  // namespace arbox::sparse
