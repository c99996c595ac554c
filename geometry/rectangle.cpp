#include "arbox/geometry/internal/rectangle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace arbox::geometry::internal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kDirections = 8;
// Below this the filter costs more than sorting all points.
constexpr std::size_t kFilterFrom = 64;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return cross(b - a, c - a); }

/// Removes points strictly inside of the polygon of the extreme points in eight directions
/// (Akl and Toussaint): they cannot be on the hull.
void drop_inner_points(std::vector<Vector2d>& points) {
  std::array<Vector2d, kDirections> extreme;
  std::array<double, kDirections> furthest;
  furthest.fill(-std::numeric_limits<double>::infinity());
  for (const Vector2d& p : points) {
    const double sum = p.x() + p.y();
    const double difference = p.y() - p.x();
    const std::array<double, kDirections> along = {p.x(),  sum,  p.y(),  difference,
                                                   -p.x(), -sum, -p.y(), -difference};
    for (std::size_t d = 0; d < kDirections; ++d) {
      if (along[d] <= furthest[d]) continue;
      furthest[d] = along[d];
      extreme[d] = p;
    }
  }
  const auto outside = [&](const Vector2d& p) {
    for (std::size_t d = 0; d < kDirections; ++d) {
      const Vector2d& a = extreme[d];
      const Vector2d& b = extreme[(d + 1) % kDirections];
      if (a != b && !(turn(a, b, p) > 0.0)) return true;
    }
    return false;
  };
  points.erase(std::partition(points.begin(), points.end(), outside), points.end());
}

double folded(double angle) {
  const double quarter = 0.5 * std::numbers::pi;
  const double result = std::remainder(angle, quarter);
  return result <= -0.5 * quarter ? result + quarter : result;
}

}  // namespace

std::vector<Vector2d> convex_hull(std::vector<Vector2d>& points) {
  if (points.size() > kFilterFrom) drop_inner_points(points);
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vector2d> hull;
  const auto walk = [&](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= base + 2 && turn(hull[hull.size() - 2], hull.back(), *p) <= 0.0) {
        hull.pop_back();
      }
      hull.push_back(*p);
    }
    hull.pop_back();
  };
  walk(points.begin(), points.end());
  walk(points.rbegin(), points.rend());
  return hull;
}

Rectangle least_rectangle(std::vector<Vector2d>& points, double least_side) {
  const std::vector<Vector2d> hull = convex_hull(points);
  const std::size_t count = hull.size();
  const auto side = [&](double length) { return std::max(length, least_side); };
  if (count < 3) {
    const Vector2d along = hull.back() - hull.front();
    return {.angle = count < 2 ? 0.0 : folded(std::atan2(along.y(), along.x())),
            .area = side(along.norm()) * side(0.0)};
  }
  const auto at = [&](std::size_t i) -> const Vector2d& { return hull[i % count]; };
  Rectangle best{.area = std::numeric_limits<double>::infinity()};
  std::size_t right = 1, top = 1, left = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d along = (at(i + 1) - at(i)).normalized();
    const Vector2d inward(-along.y(), along.x());
    const auto climb = [&](std::size_t& from, const Vector2d& direction) {
      while (from < i + 2 * count && direction.dot(at(from + 1) - at(from)) > 0.0) ++from;
    };
    right = std::max(right, i + 1);
    climb(right, along);
    top = std::max(top, right);
    climb(top, inward);
    left = std::max(left, top);
    climb(left, -along);
    const double area = side(along.dot(at(right) - at(left))) * side(inward.dot(at(top) - at(i)));
    if (area < best.area) {
      best = {.angle = folded(std::atan2(along.y(), along.x())), .area = area};
    }
  }
  return best;
}

}  // namespace arbox::geometry::internal
