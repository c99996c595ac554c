#include "arbox/heads/internal/same_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arbox::heads::internal {
namespace {

bool denser(const WeighedBox& a, const WeighedBox& b) { return a.log_density > b.log_density; }

bool near_a_corner(const Eigen::Vector3d& point, const std::array<Eigen::Vector3d, 8>& corners,
                   double tolerance) {
  return std::any_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& corner) {
    return (corner - point).squaredNorm() <= tolerance * tolerance;
  });
}

}  // namespace

double log_sum(double a, double b) {
  const double top = std::max(a, b);
  if (top == -std::numeric_limits<double>::infinity()) return top;
  return top + std::log1p(std::exp(std::min(a, b) - top));
}

bool same_solid(const geometry::Box& first, const geometry::Box& second, double tolerance) {
  if ((first.center - second.center).norm() > tolerance + 1e-9) return false;
  const auto a = geometry::corners(first), b = geometry::corners(second);
  return std::all_of(a.begin(), a.end(), [&](const Eigen::Vector3d& corner) {
    return near_a_corner(corner, b, tolerance + 1e-6 * first.size.norm());
  });
}

std::vector<WeighedBox> merged(std::vector<WeighedBox> boxes, double tolerance) {
  std::stable_sort(boxes.begin(), boxes.end(), denser);
  std::vector<WeighedBox> result;
  for (const WeighedBox& one : boxes) {
    const auto same = std::find_if(result.begin(), result.end(), [&](const WeighedBox& kept) {
      return same_solid(kept.box, one.box, tolerance * kept.box.size.norm());
    });
    if (same == result.end()) {
      result.push_back(one);
    } else {
      same->log_density = log_sum(same->log_density, one.log_density);
    }
  }
  std::stable_sort(result.begin(), result.end(), denser);
  return result;
}

}  // namespace arbox::heads::internal
