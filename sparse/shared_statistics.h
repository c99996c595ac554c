#pragma once

#include <ATen/core/Tensor.h>

#include <functional>
#include <memory>

namespace arbox::sparse {

/// While one is alive, batch norms that train on this thread normalise with the mean and variance
/// of the rows of all processes of a data-parallel run, in forward and backward, and update their
/// running statistics with those. Gradients of weight and bias stay this process's share. May be
/// nested; the innermost holds.
///
/// Every process must then call the same batch norms in the same order, also those without rows.
class SharedStatistics {
 public:
  /// Replaces a float64 tensor by its sum over all processes.
  using Sum = std::function<void(at::Tensor&)>;

  explicit SharedStatistics(Sum sum);
  ~SharedStatistics();
  SharedStatistics(const SharedStatistics&) = delete;
  SharedStatistics& operator=(const SharedStatistics&) = delete;

  /// The innermost of this thread, or nullptr.
  static std::shared_ptr<const Sum> current();

 private:
  std::shared_ptr<const Sum> outer_;
};

struct NormStatistics {
  at::Tensor mean, variance;  ///< (C) float64; biased variance.
  double count = 0;           ///< Rows of all processes.
};

/// Mean and variance over the rows (N, C), N >= 0, of all processes.
NormStatistics shared_statistics(const at::Tensor& rows, const SharedStatistics::Sum& sum);

/// (x - mean) / sqrt(variance + epsilon) * weight + bias, where mean and variance come from the
/// rows of all processes and take part in the gradient.
at::Tensor shared_batch_norm(const at::Tensor& rows, const at::Tensor& weight,
                             const at::Tensor& bias, const NormStatistics& statistics,
                             double epsilon, std::shared_ptr<const SharedStatistics::Sum> sum);

}  // namespace arbox::sparse
