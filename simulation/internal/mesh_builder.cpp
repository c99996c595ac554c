#include "arbox/simulation/internal/mesh_builder.h"

#include <cmath>
#include <numbers>

namespace arbox::simulation {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

/// Two unit vectors across the axis.
std::pair<Point, Point> across(const Point& axis) {
  const Point other = std::abs(axis.z()) < 0.9f ? Point::UnitZ() : Point::UnitX();
  const Point first = axis.cross(other).normalized();
  return {first, axis.cross(first).normalized()};
}

}  // namespace

std::uint32_t MeshBuilder::add(const Point& point) {
  mesh_.vertices.push_back(point);
  return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
}

void MeshBuilder::triangle(const Point& a, const Point& b, const Point& c, Material material) {
  const std::uint32_t first = add(a);
  add(b);
  add(c);
  mesh_.triangles.push_back({first, first + 1, first + 2});
  mesh_.materials.push_back(material);
}

void MeshBuilder::quad(const Point& a, const Point& b, const Point& c, const Point& d,
                       Material material) {
  const std::uint32_t first = add(a);
  add(b);
  add(c);
  add(d);
  mesh_.triangles.push_back({first, first + 1, first + 2});
  mesh_.triangles.push_back({first, first + 2, first + 3});
  mesh_.materials.insert(mesh_.materials.end(), 2, material);
}

void MeshBuilder::block(const Point& low, const Point& high, Material material) {
  const auto corner = [&](int i) {
    return Point(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                 i & 4 ? high.z() : low.z());
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& face : kFaces) {
    quad(corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3]), material);
  }
}

void MeshBuilder::fan(std::span<const Point> polygon, Material material) {
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    triangle(polygon[0], polygon[i - 1], polygon[i], material);
  }
}

void MeshBuilder::cylinder(const Point& from, const Point& to, float from_radius, float to_radius,
                           int sides, Material material) {
  const auto [u, v] = across((to - from).normalized());
  std::vector<Point> start, end;
  for (int i = 0; i < sides; ++i) {
    const float angle = 2.0f * kPi * static_cast<float>(i) / static_cast<float>(sides);
    const Point radial = std::cos(angle) * u + std::sin(angle) * v;
    start.push_back(from + from_radius * radial);
    end.push_back(to + to_radius * radial);
  }
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    quad(start[i], start[next], end[next], end[i], material);
  }
  fan(start, material);
  fan(end, material);
}

void MeshBuilder::ellipsoid(const Point& center, const Point& radii, Material material, int rings,
                            int sides) {
  const auto at = [&](int ring, int side) {
    const float polar = kPi * static_cast<float>(ring) / static_cast<float>(rings);
    const float angle = 2.0f * kPi * static_cast<float>(side) / static_cast<float>(sides);
    return Point(center +
                 radii.cwiseProduct(Point(std::sin(polar) * std::cos(angle),
                                          std::sin(polar) * std::sin(angle), std::cos(polar))));
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int side = 0; side < sides; ++side) {
      if (ring > 0) triangle(at(ring, side), at(ring + 1, side), at(ring, side + 1), material);
      if (ring + 1 < rings) {
        triangle(at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1), material);
      }
    }
  }
}

void MeshBuilder::limb(const Point& from, const Point& to, float from_radius, float to_radius,
                       Material material) {
  cylinder(from, to, from_radius, to_radius, 7, material);
  ellipsoid(from, Point::Constant(from_radius), material, 4, 7);
  ellipsoid(to, Point::Constant(to_radius), material, 4, 7);
}

}  // namespace arbox::simulation
