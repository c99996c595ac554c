#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <vector>

#include "arbox/training/one_cycle.h"
#include "arbox/training/tensor_chunks.h"

namespace arbox::training {

struct AdamWOptions {
  double beta2 = 0.99;
  double epsilon = 1e-8;
  double weight_decay = 0.01;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("beta2", &AdamWOptions::beta2,
                  {.help = "Decay of the mean squared gradient", .low = 0, .high = 0.9999999});
    visitor.field("epsilon", &AdamWOptions::epsilon,
                  {.help = "Added to the root of the mean squared gradient", .low = 0, .high = 1});
    visitor.field(
        "weight_decay", &AdamWOptions::weight_decay,
        {.help = "Share of every parameter that a step of rate 1 takes away", .low = 0, .high = 1});
  }
};

/// Adam with decoupled weight decay (Loshchilov and Hutter, ICLR 2019), whose momentum may change
/// from step to step; bias is corrected with the present momentum. One pass over memory for all
/// parameters; equal results at any thread count.
class AdamW {
 public:
  /// Parameters are contiguous float32 or float64 CPU tensors; throws InvalidArgument otherwise.
  AdamW(std::vector<at::Tensor> parameters, const AdamWOptions& options);

  /// The L2 norm of all gradients as one vector, summed in double; an absent gradient counts as 0.
  double gradient_norm() const;

  /// One step with the gradients times `gradient_scale`; an absent gradient counts as 0.
  void step(const CyclePoint& point, double gradient_scale = 1);

  /// Lets go of the gradients.
  void clear_gradients();

  const std::vector<at::Tensor>& parameters() const { return parameters_; }
  /// Means of gradients and of their squares, as the parameters in order, shape and type: what to
  /// save, with steps(), to go on later.
  const std::vector<at::Tensor>& first_moments() const { return first_; }
  const std::vector<at::Tensor>& second_moments() const { return second_; }
  std::int64_t steps() const { return steps_; }
  /// After the moments were filled in from a file.
  void set_steps(std::int64_t steps) { steps_ = steps; }

 private:
  std::vector<at::Tensor> gradients() const;

  std::vector<at::Tensor> parameters_, first_, second_;
  std::vector<TensorChunk> chunks_;
  AdamWOptions options_;
  std::int64_t steps_ = 0;
};

}  // namespace arbox::training
