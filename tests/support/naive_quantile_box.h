#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/geometry/quantile_box.h"

/// \file
/// Algorithm 1 of the paper's appendix B as one would write it down, stratified points and corners
/// included: the oracle of the tests and the baseline of the benchmark. Equal weights, samples that
/// all differ, a cube number of points, at least one point above q.

namespace arbox::testing {

inline std::vector<Eigen::Vector3d> naive_points(const std::vector<geometry::Box>& samples,
                                                 int side, std::uint64_t seed,
                                                 std::uint64_t object) {
  std::vector<Eigen::Vector3d> points;
  const RandomStream stream(seed, object, 0x51424f58);
  std::uint32_t index = 0;
  for (const geometry::Box& box : samples) {
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        for (int k = 0; k < side; ++k) {
          const auto words = stream.words(index++);
          const Eigen::Vector3d unit((i + (words[0] + 0.5) / 4294967296.0) / side,
                                     (j + (words[1] + 0.5) / 4294967296.0) / side,
                                     (k + (words[2] + 0.5) / 4294967296.0) / side);
          const Eigen::Vector3d local =
              (unit - Eigen::Vector3d::Constant(0.5)).cwiseProduct(box.size);
          points.push_back(box.center + box.rotation * local);
        }
      }
    }
  }
  for (const geometry::Box& box : samples) {
    for (const Eigen::Vector3d& corner : geometry::corners(box)) points.push_back(corner);
  }
  return points;
}

inline double naive_occupancy(const std::vector<geometry::Box>& samples,
                              const Eigen::Vector3d& point) {
  int inside = 0;
  for (const geometry::Box& box : samples) inside += geometry::contains(box, point, 1e-9);
  return static_cast<double>(inside) / static_cast<double>(samples.size());
}

inline geometry::Box naive_enclosing_box(const std::vector<Eigen::Vector3d>& points,
                                         const std::vector<geometry::Box>& samples) {
  geometry::Box best;
  double least = std::numeric_limits<double>::infinity();
  for (const geometry::Box& sample : samples) {
    Eigen::AlignedBox3d extents;
    for (const Eigen::Vector3d& p : points) extents.extend(sample.rotation.conjugate() * p);
    if (extents.volume() >= least) continue;
    least = extents.volume();
    best = {.center = sample.rotation * extents.center(),
            .size = extents.sizes(),
            .rotation = sample.rotation};
  }
  return best;
}

inline std::vector<geometry::Box> naive_quantile_boxes(const std::vector<geometry::Box>& samples,
                                                       const std::vector<double>& qs, int side,
                                                       std::uint64_t seed, std::uint64_t object) {
  const auto points = naive_points(samples, side, seed, object);
  std::vector<double> occupancies;
  for (const Eigen::Vector3d& point : points) {
    occupancies.push_back(naive_occupancy(samples, point));
  }
  std::vector<geometry::Box> result;
  for (const double q : qs) {
    std::vector<Eigen::Vector3d> above;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (occupancies[i] > q) above.push_back(points[i]);
    }
    result.push_back(naive_enclosing_box(above, samples));
  }
  return result;
}

}  // namespace arbox::testing
