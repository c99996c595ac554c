#include "arbox/heads/multilayer_perceptron.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/leaky_relu.h>
#include <ATen/ops/linear.h>
#include <torch/nn/modules/linear.h>

#include <string>

#include "arbox/base/error.h"

namespace arbox::heads {

MultilayerPerceptron::MultilayerPerceptron(std::int64_t inputs,
                                           std::span<const std::int64_t> hidden,
                                           std::int64_t outputs) {
  std::vector<std::int64_t> widths = {inputs};
  widths.insert(widths.end(), hidden.begin(), hidden.end());
  widths.push_back(outputs);
  for (const std::int64_t width : widths) {
    if (width < 1) {
      throw InvalidArgument("MultilayerPerceptron: expected widths of at least 1, got " +
                            std::to_string(width));
    }
  }
  for (std::size_t i = 0; i + 1 < widths.size(); ++i) {
    layers_.push_back(register_module(
        std::to_string(2 * i), std::make_shared<torch::nn::LinearImpl>(widths[i], widths[i + 1])));
  }
}

at::Tensor MultilayerPerceptron::after_first(at::Tensor rows) const {
  for (std::size_t i = 1; i < layers_.size(); ++i) {
    rows = at::linear(at::leaky_relu(rows, kLeak), layers_[i]->weight, layers_[i]->bias);
  }
  return rows;
}

at::Tensor MultilayerPerceptron::forward(const at::Tensor& rows) const {
  return after_first(at::linear(rows, layers_.front()->weight, layers_.front()->bias));
}

at::Tensor MultilayerPerceptron::forward(const at::Tensor& shared, const at::Tensor& own) const {
  const torch::nn::LinearImpl& first = *layers_.front();
  const std::int64_t split = shared.size(-1);
  const at::Tensor part = at::linear(shared, first.weight.slice(1, 0, split), first.bias);
  return after_first(part.unsqueeze(1) + at::linear(own, first.weight.slice(1, split)));
}

std::vector<MultilayerPerceptron::Layer> MultilayerPerceptron::layers() const {
  std::vector<Layer> result;
  for (const auto& layer : layers_) result.push_back({layer->weight, layer->bias});
  return result;
}

}  // namespace arbox::heads
