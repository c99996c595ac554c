#include "arbox/plugins/cgal/exact_intersection.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace arbox::cgal {
namespace {

using Number = CGAL::Exact_predicates_exact_constructions_kernel::FT;
using Vector = std::array<Number, 3>;
using Polygon = std::vector<Vector>;

Number dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Number determinant(const Vector& a, const Vector& b, const Vector& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// The points p with normal . p <= offset.
struct HalfSpace {
  Vector normal;
  Number offset;
};

struct Face {
  HalfSpace plane;
  Polygon corners;  // counter-clockwise seen from outside
};

std::array<Vector, 3> axes_of(const geometry::Quaternion& q) {
  const Number w = q.w(), x = q.x(), y = q.y(), z = q.z();
  const Number scale = Number(2) / (w * w + x * x + y * y + z * z);
  const auto diagonal = [&](const Number& a, const Number& b) -> Number {
    return 1 - scale * (a * a + b * b);
  };
  return {Vector{diagonal(y, z), scale * (x * y + w * z), scale * (x * z - w * y)},
          Vector{scale * (x * y - w * z), diagonal(x, z), scale * (y * z + w * x)},
          Vector{scale * (x * z + w * y), scale * (y * z - w * x), diagonal(x, y)}};
}

// The faces of a box whose centre is `center`.
std::vector<Face> faces_of(const geometry::Box& box, const Vector& center) {
  const std::array<Vector, 3> axes = axes_of(box.rotation);
  std::vector<Face> faces;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      const int u = (axis + (sign > 0 ? 1 : 2)) % 3, v = (axis + (sign > 0 ? 2 : 1)) % 3;
      Face face;
      for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        Vector corner;
        for (int k = 0; k < 3; ++k) {
          corner[k] = center[k] + (sign * Number(box.size[axis]) * axes[axis][k] +
                                   a * Number(box.size[u]) * axes[u][k] +
                                   b * Number(box.size[v]) * axes[v][k]) /
                                      2;
        }
        face.corners.push_back(corner);
      }
      for (int k = 0; k < 3; ++k) face.plane.normal[k] = sign * axes[axis][k];
      face.plane.offset = dot(face.plane.normal, center) + Number(box.size[axis]) / 2;
      faces.push_back(face);
    }
  }
  return faces;
}

Polygon clipped(const Polygon& polygon, const HalfSpace& half_space) {
  Polygon result;
  std::vector<Number> height;
  for (const Vector& p : polygon) height.push_back(dot(half_space.normal, p) - half_space.offset);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t next = (i + 1) % polygon.size();
    const CGAL::Sign here = CGAL::sign(height[i]), there = CGAL::sign(height[next]);
    if (here != CGAL::POSITIVE) result.push_back(polygon[i]);
    if (here * there != CGAL::NEGATIVE) continue;
    const Number share = height[i] / (height[i] - height[next]);
    Vector crossing;
    for (int k = 0; k < 3; ++k) {
      crossing[k] = polygon[i][k] + share * (polygon[next][k] - polygon[i][k]);
    }
    result.push_back(crossing);
  }
  return result;
}

// Six times the volume between the origin and the part of the face inside the other box.
Number cone(const Face& face, const std::vector<Face>& other) {
  Polygon polygon = face.corners;
  for (const Face& limit : other) {
    polygon = clipped(polygon, limit.plane);
    if (polygon.size() < 3) return 0;
  }
  Number result = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    result += determinant(polygon[0], polygon[i], polygon[i + 1]);
  }
  return result;
}

bool coincide(const HalfSpace& a, const HalfSpace& b) {
  return a.normal == b.normal && a.offset == b.offset;
}

}  // namespace

double exact_intersection(const geometry::Box& first, const geometry::Box& second) {
  geometry::require_valid(first, "exact_intersection: first");
  geometry::require_valid(second, "exact_intersection: second");
  const Vector origin{0, 0, 0};
  Vector between;
  for (int k = 0; k < 3; ++k) between[k] = Number(second.center[k]) - Number(first.center[k]);
  const std::vector<Face> a = faces_of(first, origin), b = faces_of(second, between);
  Number volume = 0;
  for (const Face& face : a) volume += cone(face, b);
  for (const Face& face : b) {
    // A face that lies in a face of the other, looking the same way, bounds the volume once.
    const bool counted = std::any_of(
        a.begin(), a.end(), [&](const Face& other) { return coincide(face.plane, other.plane); });
    if (!counted) volume += cone(face, a);
  }
  const auto [low, high] = CGAL::to_interval(volume);
  const double smaller = std::min(geometry::volume(first), geometry::volume(second));
  if (high - low > 1e-12 * smaller) return CGAL::to_double(volume.exact()) / 6.0;
  return 0.5 * (low + high) / 6.0;
}

}  // namespace arbox::cgal
