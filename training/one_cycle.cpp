#include "arbox/training/one_cycle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arbox::training {
namespace {

double cosine(double from, double to, double part) {
  return to + (from - to) / 2 * (std::cos(std::numbers::pi * std::clamp(part, 0.0, 1.0)) + 1);
}

}  // namespace

CyclePoint one_cycle(const OneCycleOptions& options, std::int64_t step, std::int64_t steps) {
  const auto top = static_cast<std::int64_t>(options.rise * static_cast<double>(steps));
  const double high = options.learning_rate;
  if (step < top) {
    const double part = static_cast<double>(step) / static_cast<double>(top);
    return {cosine(high / options.start_divisor, high, part),
            cosine(options.momentum_high, options.momentum_low, part)};
  }
  const double part =
      steps > top ? static_cast<double>(step - top) / static_cast<double>(steps - top) : 1.0;
  return {cosine(high, high / options.end_divisor, part),
          cosine(options.momentum_low, options.momentum_high, part)};
}

}  // namespace arbox::training
