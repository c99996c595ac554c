#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <vector>

#include "arbox/training/tensor_chunks.h"

namespace arbox::training {

/// An exponential moving average of weights: after step n each weight of it moves by 1 - d towards
/// the present one, where d = min(decay, (1 + n) / (10 + n)), so that the first weights are soon
/// forgotten.
class WeightAverage {
 public:
  /// Begins with the present weights: contiguous float32 or float64 tensors.
  WeightAverage(std::vector<at::Tensor> weights, double decay);

  /// After step number `step`, from 1.
  void update(std::int64_t step);

  /// Exchanges weights and average; a second call takes it back.
  void swap();

  const std::vector<at::Tensor>& values() const { return average_; }

 private:
  std::vector<at::Tensor> weights_, average_;
  std::vector<TensorChunk> chunks_;
  double decay_;
};

}  // namespace arbox::training
