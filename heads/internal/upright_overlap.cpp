#include "arbox/heads/internal/upright_overlap.h"

#include <algorithm>
#include <cmath>

namespace arbox::heads::internal {
namespace {

struct Vector {
  double x = 0.0, y = 0.0;
};

Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y}; }
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y}; }
Vector operator*(double s, const Vector& v) { return {s * v.x, s * v.y}; }
double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y; }
double cross(const Vector& a, const Vector& b) { return a.x * b.y - a.y * b.x; }
Vector perpendicular(const Vector& v) { return {-v.y, v.x}; }

struct Turn {
  explicit Turn(double angle) : cosine(std::cos(angle)), sine(std::sin(angle)) {}
  Vector operator()(const Vector& v) const {
    return {cosine * v.x - sine * v.y, sine * v.x + cosine * v.y};
  }
  double cosine, sine;
};

/// Outward normals of a rectangle's edges, counter-clockwise from its +x side.
constexpr std::array<Vector, 4> kNormals = {Vector{1, 0}, Vector{0, 1}, Vector{-1, 0},
                                            Vector{0, -1}};

struct Vertex {
  Vector point;
  int edge;  // that leaves it: 0..3 of the clipped rectangle, 4..7 of the clipping one
};

struct Polygon {
  std::array<Vertex, 12> vertices;
  int count = 0;
  void add(const Vector& point, int edge) { vertices[count++] = {point, edge}; }
  const Vertex& next(int i) const { return vertices[i + 1 == count ? 0 : i + 1]; }
};

/// The part with dot(normal, point) <= limit; the cut gets `edge`.
Polygon clip(const Polygon& polygon, const Vector& normal, double limit, int edge) {
  Polygon result;
  for (int i = 0; i < polygon.count; ++i) {
    const Vertex& from = polygon.vertices[i];
    const Vertex& to = polygon.next(i);
    const double before = limit - dot(normal, from.point), after = limit - dot(normal, to.point);
    if (before >= 0) result.add(from.point, from.edge);
    if ((before >= 0) == (after >= 0)) continue;
    const Vector cut = from.point + before / (before - after) * (to.point - from.point);
    result.add(cut, before >= 0 ? edge : from.edge);
  }
  return result;
}

/// Derivatives of the intersection's area with respect to x, y, l, w, yaw of one rectangle.
struct Derivative {
  Vector center;
  std::array<double, 2> size{};
  double yaw = 0.0;

  /// Adds an edge that bounds the intersection along `along`, with middle `arm` from the centre.
  void add(int edge, const Vector& normal, double length, const Vector& arm) {
    center = center + length * normal;
    size[edge % 2] += 0.5 * length;
    yaw += length * dot(normal, perpendicular(arm));
  }
};

struct Area {
  double value = 0.0;
  Derivative first, second;
};

/// Clips `first` by `second` in the frame of `second`.
Area intersect(const UprightBox& first, const UprightBox& second) {
  const Turn to_world(second[6]), to_local(-second[6]), turn(first[6] - second[6]);
  const Vector center = to_local({first[0] - second[0], first[1] - second[1]});
  const Vector along = turn({0.5 * first[3], 0.0}), across = turn({0.0, 0.5 * first[4]});
  Polygon polygon;
  polygon.add(center + along - across, 0);
  polygon.add(center + along + across, 1);
  polygon.add(center - along + across, 2);
  polygon.add(center - along - across, 3);
  for (int k = 0; k < 4; ++k) {
    polygon = clip(polygon, kNormals[k], 0.5 * second[3 + k % 2], 4 + k);
  }
  Area area;
  for (int i = 0; i < polygon.count; ++i) {
    const Vector from = polygon.vertices[i].point, to = polygon.next(i).point;
    const int edge = polygon.vertices[i].edge;
    const Vector middle = 0.5 * (from + to), chord = to - from;
    const double length = std::sqrt(dot(chord, chord));
    area.value += 0.5 * cross(from, to);
    if (edge < 4) {
      area.first.add(edge, turn(kNormals[edge]), length, middle - center);
    } else {
      area.second.add(edge, kNormals[edge - 4], length, middle);
    }
  }
  area.first.center = to_world(area.first.center);
  area.second.center = to_world(area.second.center);
  return area;
}

Derivative half_sum(const Derivative& a, const Derivative& b) {
  return {0.5 * (a.center + b.center),
          {0.5 * (a.size[0] + b.size[0]), 0.5 * (a.size[1] + b.size[1])},
          0.5 * (a.yaw + b.yaw)};
}

/// Overlap in height; `first` and `second` are how much the top and the bottom of each bound it.
struct Height {
  double value = 0.0;
  std::array<double, 2> first{}, second{};
};

Height overlap_in_height(const UprightBox& a, const UprightBox& b) {
  const double top_a = a[2] + 0.5 * a[5], top_b = b[2] + 0.5 * b[5];
  const double bottom_a = a[2] - 0.5 * a[5], bottom_b = b[2] - 0.5 * b[5];
  const auto share = [](double inner, double outer) {
    return inner == outer ? 0.5 : inner < outer ? 1.0 : 0.0;
  };
  Height height;
  height.value = std::min(top_a, top_b) - std::max(bottom_a, bottom_b);
  height.first = {share(top_a, top_b), share(-bottom_a, -bottom_b)};
  height.second = {1.0 - height.first[0], 1.0 - height.first[1]};
  return height;
}

/// The gradient of I / U from those of the intersection and of the own volume.
UprightBox gradient(const Derivative& area, const std::array<double, 2>& bounds, double base,
                    double height, double intersection, double all, const UprightBox& box) {
  const UprightBox inner = {
      height * area.center.x, height * area.center.y, base * (bounds[0] - bounds[1]),
      height * area.size[0],  height * area.size[1],  base * 0.5 * (bounds[0] + bounds[1]),
      height * area.yaw};
  const UprightBox volume = {0, 0, 0, box[4] * box[5], box[3] * box[5], box[3] * box[4], 0};
  UprightBox result{};
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = (inner[i] * (all + intersection) - volume[i] * intersection) / (all * all);
  }
  return result;
}

bool has_volume(const UprightBox& box) { return box[3] > 0 && box[4] > 0 && box[5] > 0; }

}  // namespace

UprightIou upright_iou(const UprightBox& first, const UprightBox& second) {
  if (!has_volume(first) || !has_volume(second)) return {};
  const Height height = overlap_in_height(first, second);
  if (!(height.value > 0)) return {};
  const Area there = intersect(first, second), back = intersect(second, first);
  const double base = 0.5 * (there.value + back.value);
  const double intersection = base * height.value;
  if (!(intersection > 0)) return {};
  const double all =
      first[3] * first[4] * first[5] + second[3] * second[4] * second[5] - intersection;
  return {intersection / all,
          gradient(half_sum(there.first, back.second), height.first, base, height.value,
                   intersection, all, first),
          gradient(half_sum(there.second, back.first), height.second, base, height.value,
                   intersection, all, second)};
}

}  // namespace arbox::heads::internal
