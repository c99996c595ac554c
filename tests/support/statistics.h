#pragma once

#include <cmath>
#include <cstdint>

namespace arbox::testing {

/// P(X <= successes) of X ~ Binomial(trials, p), 0 < p < 1: the p-value of the one-sided test that
/// refutes "the rate is at least p". Exact up to rounding; O(successes).
inline double binomial_lower_tail(std::int64_t successes, std::int64_t trials, double p) {
  const auto n = static_cast<double>(trials);
  double sum = 0.0;
  for (std::int64_t i = 0; i <= successes; ++i) {
    const auto k = static_cast<double>(i);
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) +
                    k * std::log(p) + (n - k) * std::log1p(-p));
  }
  return sum;
}

}  // namespace arbox::testing
