#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "arbox/geometry/box.h"

/// \file
/// Convex solids that a ray can hit: what made scenes are built of.

namespace arbox::testing {

/// The intersection of half-spaces normal . x <= offset, in a sphere that speeds up misses.
struct Convex {
  struct HalfSpace {
    Eigen::Vector3d normal;
    double offset;
  };
  std::vector<HalfSpace> faces = {};
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0.0;
  /// Mean intensity of its returns, 0..1.
  double intensity = 0.3;
  /// Share of the rays that pass through (windows, leaves) and that are lost.
  double passed = 0.0, lost = 0.0;
};

struct Hit {
  double distance;
  Eigen::Vector3d normal;
};

/// Where the ray from the origin along the unit `direction` enters the solid.
inline std::optional<Hit> enter(const Convex& solid, const Eigen::Vector3d& direction) {
  const double along = direction.dot(solid.center);
  if (solid.center.squaredNorm() - along * along > solid.radius * solid.radius) return {};
  double near = 0.0, far = 1e9;
  Eigen::Vector3d normal = -direction;
  for (const auto& face : solid.faces) {
    const double rate = face.normal.dot(direction);
    if (rate == 0.0) {
      if (face.offset < 0.0) return {};
      continue;
    }
    const double distance = face.offset / rate;
    if (rate < 0.0) {
      if (distance > near) {
        near = distance;
        normal = face.normal;
      }
    } else {
      far = std::min(far, distance);
    }
  }
  if (near >= far || near <= 0.0) return {};
  return Hit{near, normal};
}

/// A box whose upper face is narrower: `inset` metres at the front (+x), the back and the sides.
inline Convex tapered_box(const geometry::Box& box, double front = 0.0, double back = 0.0,
                          double sides = 0.0) {
  const Eigen::Vector3d half = 0.5 * box.size;
  Convex solid;
  const auto face = [&](const Eigen::Vector3d& normal, const Eigen::Vector3d& point) {
    const Eigen::Vector3d turned = box.rotation * normal.normalized();
    const Eigen::Vector3d place = box.center + box.rotation * point;
    solid.faces.push_back({turned, turned.dot(place)});
  };
  face({0, 0, 1}, {0, 0, half.z()});
  face({0, 0, -1}, {0, 0, -half.z()});
  face({box.size.z(), 0, front}, {half.x(), 0, -half.z()});
  face({-box.size.z(), 0, back}, {-half.x(), 0, -half.z()});
  face({0, box.size.z(), sides}, {0, half.y(), -half.z()});
  face({0, -box.size.z(), sides}, {0, -half.y(), -half.z()});
  solid.center = box.center;
  solid.radius = half.norm();
  return solid;
}

/// An upright prism with `sides` faces around a circle.
inline Convex upright_prism(const Eigen::Vector3d& center, double radius, double height,
                            int sides = 10) {
  Convex solid{.center = center, .radius = std::hypot(radius, 0.5 * height)};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * M_PI * i / sides;
    const Eigen::Vector3d normal(std::cos(angle), std::sin(angle), 0.0);
    solid.faces.push_back({normal, normal.dot(center) + radius * std::cos(M_PI / sides)});
  }
  for (double side : {1.0, -1.0}) {
    const Eigen::Vector3d normal(0, 0, side);
    solid.faces.push_back({normal, normal.dot(center) + 0.5 * height});
  }
  return solid;
}

}  // namespace arbox::testing
