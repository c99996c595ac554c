#include "arbox/drawing/internal/projection.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arbox::drawing {
namespace {

constexpr double kFieldOfView = 40.0 * M_PI / 180.0;

Point pixel(const Eigen::Vector3d& homogeneous) { return homogeneous.head<2>() / homogeneous.z(); }

Eigen::Vector3d at_near(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double near) {
  return a + (near - a.z()) / (b.z() - a.z()) * (b - a);
}

}  // namespace

std::optional<Point> Projection::operator()(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d h = homogeneous(point);
  if (!(h.z() >= near)) return std::nullopt;
  return pixel(h);
}

std::optional<std::pair<Point, Point>> Projection::segment(const Eigen::Vector3d& from,
                                                           const Eigen::Vector3d& to) const {
  Eigen::Vector3d a = homogeneous(from), b = homogeneous(to);
  if (a.z() < near && b.z() < near) return std::nullopt;
  if (a.z() < near)
    a = at_near(b, a, near);
  else if (b.z() < near)
    b = at_near(a, b, near);
  return std::make_pair(pixel(a), pixel(b));
}

std::vector<Point> Projection::polygon(const std::vector<Eigen::Vector3d>& corners) const {
  std::vector<Point> result;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d a = homogeneous(corners[i]);
    const Eigen::Vector3d b = homogeneous(corners[(i + 1) % corners.size()]);
    if (a.z() >= near) result.push_back(pixel(a));
    if ((a.z() < near) != (b.z() < near)) result.push_back(pixel(at_near(a, b, near)));
  }
  return result;
}

Projection birdseye_projection(const Eigen::Vector3d& center, double pixels_per_metre,
                               const Rect& rect) {
  Projection projection;
  projection.matrix << 0, -pixels_per_metre, 0, rect.center().x() + pixels_per_metre * center.y(),
      -pixels_per_metre, 0, 0, rect.center().y() + pixels_per_metre * center.x(), 0, 0, 0, 1;
  return projection;
}

Projection perspective_projection(std::span<const Eigen::Vector3d> shown, double azimuth,
                                  double elevation, const Rect& rect) {
  const double a = azimuth * M_PI / 180.0, e = elevation * M_PI / 180.0;
  const Eigen::Vector3d toward(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  const Eigen::Vector3d right(-std::sin(a), std::cos(a), 0.0);
  const Eigen::Vector3d up = toward.cross(right);
  const double focal = 0.5 * rect.height() / std::tan(kFieldOfView / 2);
  const double half_width = 0.5 * rect.width() / focal, half_height = 0.5 * rect.height() / focal;
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& p : shown) bounds.extend(p);
  Eigen::Vector3d target = bounds.center();
  double distance = 0.0;
  // Near points spread more than far ones, so the middle of the picture is found by iteration.
  for (int round = 0; round < 20; ++round) {
    Point first = Point::Constant(std::numeric_limits<double>::infinity()), last = -first;
    const double from = distance;
    distance = 0.1;
    for (const Eigen::Vector3d& point : shown) {
      const Eigen::Vector3d p = point - target;
      const Point across(right.dot(p), up.dot(p));
      const double toward_eye = toward.dot(p);
      distance = std::max({distance, toward_eye + std::abs(across.x()) / half_width,
                           toward_eye + std::abs(across.y()) / half_height, toward_eye + 0.1});
      const Point on_screen = across / std::max(0.1, from - toward_eye);
      first = first.cwiseMin(on_screen);
      last = last.cwiseMax(on_screen);
    }
    if (round == 0 || round == 19) continue;
    const Point shift = 0.4 * distance * (first + last) / 2;
    target += shift.x() * right + shift.y() * up;
  }
  const Eigen::Vector3d eye = target + distance * toward;
  Eigen::Matrix3d axes;
  axes.row(0) = focal * right - rect.center().x() * toward;
  axes.row(1) = -focal * up - rect.center().y() * toward;
  axes.row(2) = -toward;
  Projection projection;
  projection.matrix.leftCols<3>() = axes;
  projection.matrix.col(3) = -axes * eye;
  projection.near = 0.02 * distance;
  return projection;
}

}  // namespace arbox::drawing
