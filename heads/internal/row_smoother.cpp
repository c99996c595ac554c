#include "arbox/heads/internal/row_smoother.h"

#include <algorithm>
#include <cmath>

namespace arbox::heads::internal {
namespace {

/// Keeps logarithms finite.
constexpr double kLeastProbability = 1e-37;

double variance(std::int64_t half_width) {
  const double width = 2.0 * static_cast<double>(half_width) + 1.0;
  return (width * width - 1.0) / 12.0;
}

}  // namespace

RowSmoother::RowSmoother(double standard_deviation) {
  double left = standard_deviation * standard_deviation;
  for (int i = 0; i < 3; ++i) {
    const double share = left / (3 - i);
    half_widths_[i] = std::llround((std::sqrt(12.0 * share + 1.0) - 1.0) / 2.0);
    left = std::max(0.0, left - variance(half_widths_[i]));
  }
}

double RowSmoother::standard_deviation() const {
  double sum = 0.0;
  for (const std::int64_t half : half_widths_) sum += variance(half);
  return std::sqrt(sum);
}

std::int64_t RowSmoother::reach() const {
  return half_widths_[0] + half_widths_[1] + half_widths_[2];
}

void RowSmoother::smooth(std::span<float> log_probability, bool circular) {
  const std::int64_t bins = std::ssize(log_probability), beyond = reach();
  if (bins == 0 || beyond == 0) return;
  values_.assign(bins + 2 * beyond, 0.0);
  for (std::int64_t i = 0; i < bins; ++i) values_[beyond + i] = std::exp(log_probability[i]);
  if (circular) {
    for (std::int64_t i = 0; i < beyond; ++i) {
      values_[beyond + bins + i] = values_[beyond + i % bins];
      values_[beyond - 1 - i] = values_[beyond + bins - 1 - i % bins];
    }
  }
  for (const std::int64_t half : half_widths_) {
    const std::int64_t width = 2 * half + 1;
    sums_.resize(values_.size() - width + 1);
    double sum = 0.0;
    for (std::int64_t i = 0; i < width; ++i) sum += values_[i];
    sums_[0] = sum / static_cast<double>(width);
    for (std::size_t i = 1; i < sums_.size(); ++i) {
      sum += values_[i + width - 1] - values_[i - 1];
      sums_[i] = sum / static_cast<double>(width);
    }
    std::swap(values_, sums_);
  }
  for (std::int64_t i = 0; i < bins; ++i) {
    log_probability[i] = static_cast<float>(std::log(std::max(values_[i], kLeastProbability)));
  }
}

}  // namespace arbox::heads::internal
