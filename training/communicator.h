#pragma once

#include <ATen/core/Tensor.h>

namespace arbox::training {

/// The processes that train one network together. This one is alone.
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }
  /// Replaces the tensor, in every process, by the sum over the processes. Every process must call
  /// it with the same shape in the same order. Throws NumericalError never, IoError if a process is
  /// gone.
  virtual void sum(at::Tensor& /*tensor*/) {}
};

}  // namespace arbox::training
