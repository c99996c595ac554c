#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "arbox/detectors/cluster_fit/cluster_fit.h"

namespace arbox::detectors::internal {

/// Height of the ground under every place around the sensor (at the origin, z up).
///
/// Bins of a polar grid hold their lowest returns. A plane through the near ones starts one Kalman
/// filter (height, slope) a sector; each walks outwards, takes what fits its prediction for ground
/// and leans on its neighbours where nothing fits.
class GroundSurface {
 public:
  /// Points must be finite and within max_range. No points: the plane z = 0.
  GroundSurface(std::span<const Eigen::Vector3f> points, const GroundOptions& options,
                double max_range, int threads);

  /// Height of the ground at (x, y), metres; beyond the last ring that of the last ring.
  float height(float x, float y) const;
  /// The same under each point.
  std::vector<float> heights(std::span<const Eigen::Vector3f> points) const;

 private:
  struct Plane {
    double a = 0.0, b = 0.0, c = 0.0;  // z = a x + b y + c
  };
  struct Bin;

  float between(float ring, float turn) const;
  std::vector<Bin> lowest_returns(std::span<const Eigen::Vector3f> points, int threads) const;
  Plane near_plane(const std::vector<Bin>& bins) const;
  void walk(const std::vector<Bin>& bins, const Plane& plane);
  void fill(const std::vector<char>& measured);

  GroundOptions options_;
  int rings_ = 0;
  std::vector<float> radius_;   // of each ring's centre
  std::vector<float> heights_;  // rings x sectors
};

}  // namespace arbox::detectors::internal
