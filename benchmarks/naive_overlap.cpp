#include "naive_overlap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/base/random.h"

namespace arbox::benchmarks {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::Box;

// The points p with normal . p <= offset.
template <class Vector>
struct HalfSpace {
  Vector normal;
  double offset;
};

template <class Vector>
std::vector<Vector> clipped(const std::vector<Vector>& polygon, const HalfSpace<Vector>& limit,
                            std::vector<Vector>* cut = nullptr) {
  std::vector<Vector> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector& a = polygon[i];
    const Vector& b = polygon[(i + 1) % polygon.size()];
    const double da = limit.normal.dot(a) - limit.offset, db = limit.normal.dot(b) - limit.offset;
    if (da <= 0.0) result.push_back(a);
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) {
      result.push_back(a + da / (da - db) * (b - a));
      if (cut != nullptr) cut->push_back(result.back());
    } else if (da == 0.0 && cut != nullptr) {
      cut->push_back(a);
    }
  }
  return result;
}

std::vector<Vector2d> base(const Box& box) {
  const auto corners = geometry::corners(box);
  return {corners[0].head<2>(), corners[1].head<2>(), corners[3].head<2>(), corners[2].head<2>()};
}

double yaw_intersection(const Box& first, const Box& second) {
  std::vector<Vector2d> polygon = base(first);
  const std::vector<Vector2d> clip = base(second);
  for (int i = 0; i < 4; ++i) {
    const Vector2d edge = clip[(i + 1) % 4] - clip[i];
    const Vector2d normal(edge.y(), -edge.x());
    polygon = clipped<Vector2d>(polygon, {normal, normal.dot(clip[i])});
  }
  double area = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  const double low =
      std::max(first.center.z() - first.size.z() / 2, second.center.z() - second.size.z() / 2);
  const double high =
      std::min(first.center.z() + first.size.z() / 2, second.center.z() + second.size.z() / 2);
  return std::max(0.0, high - low) * area;
}

void order_around_centroid(std::vector<Vector3d>& polygon, const Vector3d& normal) {
  Vector3d center = Vector3d::Zero();
  for (const Vector3d& p : polygon) center += p / static_cast<double>(polygon.size());
  const Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  std::sort(polygon.begin(), polygon.end(), [&](const Vector3d& a, const Vector3d& b) {
    return std::atan2(y.dot(a - center), x.dot(a - center)) <
           std::atan2(y.dot(b - center), x.dot(b - center));
  });
}

double free_intersection(const Box& first, const Box& second) {
  const auto corner = geometry::corners(first);
  std::vector<std::vector<Vector3d>> faces;
  for (const auto& f : {std::array{0, 4, 6, 2},
                        {1, 3, 7, 5},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 2, 3, 1},
                        {4, 5, 7, 6}}) {
    faces.push_back({corner[f[0]], corner[f[1]], corner[f[2]], corner[f[3]]});
  }
  const Eigen::Matrix3d axes = second.rotation.toRotationMatrix();
  for (int side = 0; side < 6; ++side) {
    const Vector3d normal = (side % 2 ? 1.0 : -1.0) * axes.col(side / 2);
    const HalfSpace<Vector3d> limit{normal, normal.dot(second.center) + second.size[side / 2] / 2};
    std::vector<std::vector<Vector3d>> kept;
    std::vector<Vector3d> cap;
    for (const auto& face : faces) {
      std::vector<Vector3d> part = clipped(face, limit, &cap);
      if (part.size() >= 3) kept.push_back(std::move(part));
    }
    if (cap.size() >= 3) {
      order_around_centroid(cap, normal);
      kept.push_back(std::move(cap));
    }
    faces = std::move(kept);
  }
  double volume = 0.0;
  for (const auto& face : faces) {
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      volume +=
          (face[0] - first.center).dot((face[i] - first.center).cross(face[i + 1] - first.center)) /
          6;
    }
  }
  return volume;
}

template <class Intersection>
std::vector<double> naive_iou(std::span<const Box> first, std::span<const Box> second,
                              Intersection intersection) {
  std::vector<double> result;
  result.reserve(first.size() * second.size());
  for (const Box& a : first) {
    for (const Box& b : second) {
      const double volume = intersection(a, b);
      result.push_back(volume / (geometry::volume(a) + geometry::volume(b) - volume));
    }
  }
  return result;
}

Box car(const RandomStream& stream) {
  const Vector3d center(stream.uniform(0, 0, 70), stream.uniform(1, -35, 35),
                        stream.uniform(2, -1.2, -0.8));
  const Vector3d size(stream.uniform(3, 3.4, 4.6), stream.uniform(4, 1.5, 1.9),
                      stream.uniform(5, 1.4, 1.7));
  return geometry::make_yaw_box(center, size,
                                stream.uniform(6, -std::numbers::pi, std::numbers::pi));
}

}  // namespace

std::vector<double> naive_yaw_iou(std::span<const Box> first, std::span<const Box> second) {
  return naive_iou(first, second, yaw_intersection);
}

std::vector<double> naive_free_iou(std::span<const Box> first, std::span<const Box> second) {
  return naive_iou(first, second, free_intersection);
}

std::vector<Box> spread_cars(int count, std::uint64_t seed) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) boxes.push_back(car(RandomStream(seed, i, 0)));
  return boxes;
}

std::vector<Box> clustered_proposals(int count, std::uint64_t seed) {
  constexpr int kCars = 15;
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const RandomStream stream(seed, i, 1);
    Box box = car(RandomStream(0, i % kCars, 2));
    for (int axis = 0; axis < 3; ++axis) {
      box.center[axis] += 0.3 * stream.normal(axis);
      box.size[axis] *= std::exp(0.05 * stream.normal(3 + axis));
    }
    boxes.push_back(
        geometry::make_yaw_box(box.center, box.size, geometry::yaw(box) + 0.1 * stream.normal(6)));
  }
  return boxes;
}

std::vector<Box> dense_boxes(int count, std::uint64_t seed, double room) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const RandomStream stream(seed, i, 3);
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.center[axis] = stream.uniform(axis, 0, room);
      box.size[axis] = stream.uniform(3 + axis, 0.2, 1.2);
    }
    box.rotation =
        geometry::Quaternion(stream.normal(6), stream.normal(7), stream.normal(8), stream.normal(9))
            .normalized();
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace arbox::benchmarks
