#include "arbox/evaluation/conformal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "arbox/base/error.h"

namespace arbox::evaluation {

std::int64_t conformal_rank(std::int64_t n, double p) {
  if (!(p > 0.0 && p < 1.0)) {
    throw InvalidArgument("conformal_rank: expected a probability in (0, 1), got " +
                          std::to_string(p));
  }
  if (n < 0) throw InvalidArgument("conformal_rank: expected n >= 0, got " + std::to_string(n));
  // Without the allowance 0.9 of 9 + 1 objects, 9.000000000000002, would ask for rank 10.
  const double exact = static_cast<double>(n + 1) * p;
  return static_cast<std::int64_t>(std::ceil(exact * (1.0 - 1e-14)));
}

std::int64_t conformal_objects_needed(double p) {
  auto n = static_cast<std::int64_t>(std::floor(p / (1.0 - p)));
  while (n > 0 && conformal_rank(n - 1, p) <= n - 1) --n;
  while (conformal_rank(n, p) > n) ++n;
  return n;
}

double conformal_threshold(std::span<const double> scores, double p) {
  const std::int64_t rank = conformal_rank(static_cast<std::int64_t>(scores.size()), p);
  if (std::any_of(scores.begin(), scores.end(), [](double score) { return std::isnan(score); })) {
    throw InvalidArgument("conformal_threshold: a score is not a number");
  }
  if (rank > static_cast<std::int64_t>(scores.size())) {
    return std::numeric_limits<double>::infinity();
  }
  std::vector<double> copy(scores.begin(), scores.end());
  const auto place = copy.begin() + (rank - 1);
  std::nth_element(copy.begin(), place, copy.end());
  return *place;
}

}  // namespace arbox::evaluation
