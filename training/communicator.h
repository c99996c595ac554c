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
  /// it with the same shape in the same order. Throws IoError if a process is gone.
  virtual void sum(at::Tensor& /*tensor*/) {}
  /// Returns once every process has called it. Throws IoError if a process is gone or does not come
  /// within `seconds`.
  virtual void wait(double /*seconds*/) {}
};

}  // namespace arbox::training
