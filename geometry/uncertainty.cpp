#include <cmath>

#include "arbox/base/error.h"
#include "arbox/geometry/internal/sample_set.h"
#include "arbox/geometry/overlap.h"
#include "arbox/geometry/quantile_box.h"

namespace arbox::geometry {

double quantile_uncertainty(const Box& first, const Box& second) {
  return 1.0 - overlap(first, second);
}

double gaussian_uncertainty(const Eigen::Vector3d& size_deviation,
                            const Eigen::Vector3d& size_mean) {
  const bool valid = size_deviation.allFinite() && (size_deviation.array() >= 0.0).all() &&
                     size_mean.allFinite() && (size_mean.array() > 0.0).all();
  if (!valid) {
    throw InvalidArgument(
        "gaussian_uncertainty: deviations must be finite and at least 0, means finite and above 0");
  }
  return (size_deviation.array() / size_mean.array()).prod();
}

double gaussian_uncertainty(const BoxSamples& samples) {
  internal::require_valid(samples, "gaussian_uncertainty");
  const internal::SampleSet set = internal::make_sample_set(samples);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < set.boxes.size(); ++i) {
    mean += set.weights[i] / set.total_weight * set.boxes[i].size;
  }
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < set.boxes.size(); ++i) {
    const Eigen::Vector3d off = set.boxes[i].size - mean;
    variance += set.weights[i] / set.total_weight * off.cwiseAbs2();
  }
  return gaussian_uncertainty(variance.cwiseSqrt(), mean);
}

}  // namespace arbox::geometry
