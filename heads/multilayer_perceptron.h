#pragma once

#include <ATen/core/ivalue.h>  // before nn headers: clang cannot parse them otherwise

#include <torch/nn/module.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace torch::nn {
class LinearImpl;
}

namespace arbox::heads {

/// Slope of the leaky rectifiers between layers.
inline constexpr double kLeak = 0.1;

/// Fully connected layers with leaky rectifiers (slope 0.1) between them and none after the last.
/// Parameters have the keys 0.weight, 0.bias, 2.weight, ...: the numbers of a sequence that counts
/// the rectifiers, as in the paper's checkpoints. LibTorch's default initialisation.
class MultilayerPerceptron : public torch::nn::Module {
 public:
  /// Weight (out, in) and bias (out).
  struct Layer {
    at::Tensor weight, bias;
  };

  MultilayerPerceptron(std::int64_t inputs, std::span<const std::int64_t> hidden,
                       std::int64_t outputs);

  /// (..., inputs) -> (..., outputs).
  at::Tensor forward(const at::Tensor& rows) const;

  /// Rows that share a part of their input: shared (N, S) and own (N, M, inputs - S) -> (N, M,
  /// outputs), forward() of the two side by side. The first layer's work on `shared` is done once.
  at::Tensor forward(const at::Tensor& shared, const at::Tensor& own) const;

  std::vector<Layer> layers() const;

 private:
  at::Tensor after_first(at::Tensor rows) const;

  std::vector<std::shared_ptr<torch::nn::LinearImpl>> layers_;
};

}  // namespace arbox::heads
