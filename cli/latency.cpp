#include "arbox/cli/latency.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace arbox::cli {
namespace {

constexpr double kStep = 1.05;
constexpr double kShortest = 1e-3;

}  // namespace

void LatencyCount::add(double milliseconds) {
  const double step =
      std::ceil(std::log(std::max(milliseconds, kShortest) / kShortest) / std::log(kStep));
  const auto last = static_cast<double>(steps_.size() - 1);
  ++steps_[static_cast<std::size_t>(std::clamp(step, 0.0, last))];
  ++count_;
  longest_ = std::max(longest_, milliseconds);
}

double LatencyCount::quantile(double share) const {
  const double wanted = share * static_cast<double>(count_);
  std::uint64_t seen = 0;
  for (std::size_t step = 0; step < steps_.size(); ++step) {
    seen += steps_[step];
    if (seen > 0 && static_cast<double>(seen) >= wanted) {
      return std::min(longest_, kShortest * std::pow(kStep, static_cast<double>(step)));
    }
  }
  return 0.0;
}

std::string LatencyCount::text() const {
  return fmt::format("latency median {:.1f} ms, 95 % {:.1f} ms, longest {:.1f} ms", quantile(0.5),
                     quantile(0.95), longest_);
}

}  // namespace arbox::cli
