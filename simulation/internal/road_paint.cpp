#include "arbox/simulation/internal/road_paint.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace arbox::simulation {
namespace {

constexpr double kHalfWidth = 0.07;
constexpr double kDash = 3.0, kPeriod = 7.5;

/// Distance along the course and to the left of it.
Eigen::Vector2d along_course(double curvature, const Eigen::Vector3d& point) {
  if (std::abs(curvature) < 1e-7) return point.head<2>();
  const double radius = 1.0 / curvature, sign = curvature > 0 ? 1.0 : -1.0;
  const double dx = sign * point.x(), dy = sign * (radius - point.y());
  return {std::atan2(dx, dy) * radius, radius - sign * std::hypot(dx, dy)};
}

double grid_value(std::int64_t i, std::int64_t j) {
  auto bits = static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15u ^
              static_cast<std::uint64_t>(j) * 0xc2b2ae3d27d4eb4fu;
  bits ^= bits >> 29;
  bits *= 0xbf58476d1ce4e5b9u;
  bits ^= bits >> 32;
  return static_cast<double>(bits & 0xffff) / 32767.5 - 1.0;
}

}  // namespace

bool is_painted(const RoadMarkings& markings, const Eigen::Vector3d& point) {
  if (markings.lines.empty()) return false;
  const Eigen::Vector2d place = along_course(markings.curvature, point);
  const double s = place.x(), t = place.y();
  const auto covers = [&](const RoadMarkings::Line& line) {
    const double phase = s - kPeriod * std::floor(s / kPeriod);
    return std::abs(t - line.offset) < kHalfWidth && (!line.dashed || phase < kDash);
  };
  if (std::none_of(markings.lines.begin(), markings.lines.end(), covers)) return false;
  return std::none_of(markings.gaps.begin(), markings.gaps.end(), [&](const auto& gap) {
    return gap.left == (t > 0) && s > gap.from && s < gap.to;
  });
}

double patchiness(const Eigen::Vector3d& point, double wavelength) {
  const double u = point.x() / wavelength, v = point.y() / wavelength;
  const double i = std::floor(u), j = std::floor(v);
  const auto ease = [](double a) { return a * a * (3 - 2 * a); };
  const double a = ease(u - i), b = ease(v - j);
  const auto x = static_cast<std::int64_t>(i), y = static_cast<std::int64_t>(j);
  return (grid_value(x, y) * (1 - a) + grid_value(x + 1, y) * a) * (1 - b) +
         (grid_value(x, y + 1) * (1 - a) + grid_value(x + 1, y + 1) * a) * b;
}

}  // namespace arbox::simulation
