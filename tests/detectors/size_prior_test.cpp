#include "arbox/detectors/cluster_fit/internal/size_prior.h"

#include <gtest/gtest.h>

#include <cmath>

namespace arbox::detectors::internal {
namespace {

struct Integrals {
  double evidence = 0.0, mean = 0.0;
};

/// The same posterior by summing it up.
Integrals integrate(double mean, double deviation, double slack, double extent, bool visible) {
  Integrals sum;
  double mass = 0.0;
  const double step = 1e-4;
  for (double size = extent + 0.5 * step; size < extent + 12.0; size += step) {
    const double z = (size - mean) / deviation;
    double density = std::exp(-0.5 * z * z) / (deviation * std::sqrt(2.0 * M_PI));
    density *= visible ? std::exp(-(size - extent) / slack) / slack : 1.0 / mean;
    mass += density * step;
    sum.mean += size * density * step;
  }
  sum.evidence = mass;
  sum.mean /= mass;
  return sum;
}

TEST(SizePosterior, AgreesWithNumericalIntegration) {
  for (const double extent : {0.3, 1.2, 2.5, 3.5, 3.9, 4.3, 5.0}) {
    for (const bool visible : {false, true}) {
      const SizePosterior posterior(3.884, 0.426, 0.2, extent, visible, 0.0);
      const Integrals expected = integrate(3.884, 0.426, 0.2, extent, visible);
      EXPECT_NEAR(posterior.log_evidence(), std::log(expected.evidence), 2e-3)
          << "extent " << extent << ", visible " << visible;
      EXPECT_NEAR(posterior.mean(), expected.mean, 2e-3)
          << "extent " << extent << ", visible " << visible;
    }
  }
}

TEST(SizePosterior, QuantilesRiseAndAverageToTheMean) {
  for (const double extent : {0.3, 3.0, 3.9, 4.6, 6.5}) {
    for (const bool visible : {false, true}) {
      const SizePosterior posterior(3.884, 0.426, 0.2, extent, visible, 0.06);
      double sum = 0.0, last = extent;
      for (int i = 0; i < 1000; ++i) {
        const double size = posterior.quantile((i + 0.5) / 1000.0);
        ASSERT_GE(size, last);
        ASSERT_TRUE(std::isfinite(size));
        sum += last = size;
      }
      EXPECT_NEAR(sum / 1000.0, posterior.mean(), 0.01)
          << "extent " << extent << ", visible " << visible;
    }
  }
}

TEST(SizePosterior, StaysFiniteFarFromTheClass) {
  for (const double extent : {1e-3, 30.0, 200.0}) {
    for (const bool visible : {false, true}) {
      const SizePosterior posterior(0.66, 0.143, 0.15, extent, visible, 0.06);
      EXPECT_TRUE(std::isfinite(posterior.log_evidence()));
      EXPECT_GE(posterior.mean(), extent);
      EXPECT_GE(posterior.quantile(0.0), extent);
      EXPECT_TRUE(std::isfinite(posterior.quantile(0.999999)));
    }
  }
}

TEST(SizePriors, LieWhereTheDataSetsLabelsLie) {
  double shares = 0.0;
  for (const SizePrior& prior : kSizePriors) {
    EXPECT_TRUE((prior.deviation.array() > 0.0).all() && (prior.slack.array() > 0.0).all());
    EXPECT_TRUE((prior.mean.array() > 3.0 * prior.deviation.array()).all()) << prior.label;
    shares += prior.share;
  }
  EXPECT_NEAR(shares, 1.0, 1e-9);
}

}  // namespace
}  // namespace arbox::detectors::internal
