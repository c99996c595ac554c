#pragma once

#include <cstdint>

#include "arbox/heads/internal/aligned_floats.h"

namespace arbox::heads::internal {

/// softmax(logits / temperature) of one row after the other. Keeps its memory; one a thread.
class SoftmaxRow {
 public:
  /// `logits` (columns), padded as LogitBlock is.
  void set(const float* logits, std::int32_t columns, double temperature);

  /// False if the logits were not finite: there is no distribution then.
  bool valid() const { return valid_; }

  /// Logarithm of the sum of exp(logits), at temperature 1; NaN unless valid().
  float log_normalizer() const { return log_normalizer_; }

  /// Where the cumulative probability passes `uniform` in [0, 1). Needs valid().
  std::int32_t draw(double uniform) const;

 private:
  AlignedFloats exponentials_, sums_;
  float total_ = 0.0f, log_normalizer_ = 0.0f;
  bool valid_ = false;
};

}  // namespace arbox::heads::internal
