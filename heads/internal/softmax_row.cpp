#include "arbox/heads/internal/softmax_row.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "arbox/heads/internal/mlp_kernel.h"

namespace arbox::heads::internal {

void SoftmaxRow::set(const float* logits, std::int32_t columns, double temperature) {
  exponentials_.resize(columns);
  sums_.resize(columns / kColumnBlock);
  const MlpKernels& kernels = mlp_kernels();
  const float top = kernels.largest(logits, columns);
  const auto sum_at = [&](float scale) {
    kernels.exponentials(logits, columns, top, scale, exponentials_.data(), sums_.data());
    return std::accumulate(sums_.begin(), sums_.end(), 0.0f);
  };
  const float plain = sum_at(1.0f);
  total_ =
      temperature == 1.0 ? plain : sum_at(static_cast<float>(std::min(1.0 / temperature, 1e30)));
  log_normalizer_ = top + std::log(plain);
  valid_ = total_ > 0.0f && std::isfinite(log_normalizer_);
  if (!valid_) log_normalizer_ = std::numeric_limits<float>::quiet_NaN();
}

std::int32_t SoftmaxRow::draw(double uniform) const {
  const auto target = static_cast<float>(uniform * total_);
  float before = 0.0f, sum = 0.0f;
  std::int32_t block = -1;  // the first that passes the target, else the last with any mass
  for (std::size_t b = 0; b < sums_.size(); ++b) {
    if (sums_[b] > 0.0f) {
      block = static_cast<std::int32_t>(b);
      before = sum;
      sum += sums_[b];
      if (sum > target) break;
    }
  }
  const std::int32_t first = block * kColumnBlock;
  std::int32_t last_with_mass = first;
  for (std::int32_t j = first; j < first + kColumnBlock; ++j) {
    if (exponentials_[j] > 0.0f) {
      last_with_mass = j;
      before += exponentials_[j];
      if (before > target) break;
    }
  }
  return last_with_mass;
}

}  // namespace arbox::heads::internal
