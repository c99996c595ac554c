#include "arbox/detectors/cluster_fit/internal/size_prior.h"

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numbers>

namespace arbox::detectors::internal {
namespace {

// Beyond this many deviations the tail of the normal is taken for an exponential.
constexpr double kFarTail = 5.0;

/// Log of the share of a standard normal above x.
double log_tail(double x) {
  if (x < kFarTail) return std::log(0.5 * std::erfc(x / std::numbers::sqrt2));
  return -0.5 * x * x - std::log(x * std::sqrt(2.0 * std::numbers::pi)) +
         std::log1p(-1.0 / (x * x));
}

}  // namespace

SizePosterior::SizePosterior(double mean, double deviation, double slack, double extent,
                             bool ends_visible, double noise)
    : centre_(mean), deviation_(std::hypot(deviation, noise)), extent_(extent) {
  if (ends_visible) {
    const double variance = deviation_ * deviation_;
    centre_ -= variance / slack;
    log_evidence_ = -std::log(slack) + (extent - mean) / slack + 0.5 * variance / (slack * slack) +
                    log_tail((extent - centre_) / deviation_);
  } else {
    log_evidence_ = -std::log(mean) + log_tail((extent - centre_) / deviation_);
  }
}

double SizePosterior::mean() const {
  const double cut = (extent_ - centre_) / deviation_;
  const double log_density = -0.5 * cut * cut - 0.5 * std::log(2.0 * std::numbers::pi);
  return std::max(extent_, centre_ + deviation_ * std::exp(log_density - log_tail(cut)));
}

double SizePosterior::quantile(double u) const {
  const double cut = (extent_ - centre_) / deviation_;
  if (cut >= kFarTail) return extent_ - deviation_ / cut * std::log1p(-u);
  const double above = (1.0 - u) * 0.5 * std::erfc(cut / std::numbers::sqrt2);
  const double tail = std::clamp(2.0 * above, 1e-300, 2.0 - 1e-15);
  return std::max(extent_,
                  centre_ + deviation_ * std::numbers::sqrt2 * boost::math::erfc_inv(tail));
}

}  // namespace arbox::detectors::internal
