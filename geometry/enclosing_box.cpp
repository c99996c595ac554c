#include "arbox/geometry/enclosing_box.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/geometry/internal/enclosing.h"
#include "arbox/geometry/rotation.h"

namespace arbox::geometry {
namespace {

using namespace internal;
using Eigen::Vector3d;

constexpr int kCover = 48;
constexpr std::size_t kCoarse = 24;
constexpr std::size_t kFine = 4;
constexpr TiltSteps kCoarseSteps = {.first = 0.2, .last = 0.01};
constexpr TiltSteps kFineSteps = {.first = 0.01, .last = 1e-7};

struct Problem {
  Vector3d origin;
  PointSet points;
  double least_size;
};

/// Nothing for no points.
std::optional<Problem> make_problem(std::span<const Vector3d> points, double minimum_size,
                                    const std::string& where) {
  if (!(minimum_size > 0.0 && std::isfinite(minimum_size))) {
    throw InvalidArgument(where + ": minimum_size must be finite and above 0, got " +
                          std::to_string(minimum_size));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite()) continue;
    throw InvalidArgument(where + ": the point in row " + std::to_string(i) + " is not finite");
  }
  if (points.empty()) return std::nullopt;
  Problem problem{.origin = points.front(), .points = {}, .least_size = minimum_size};
  problem.points.reserve(points.size());
  for (const Vector3d& point : points) {
    const Vector3d local = point - problem.origin;
    problem.points.push_back(local.x(), local.y(), local.z());
  }
  problem.points.pad();
  return problem;
}

Box finished(const Problem& problem, Box box) {
  box.center += problem.origin;
  box.size = box.size.cwiseMax(problem.least_size);
  return box;
}

double volume_in(const Problem& problem, const Box& box) {
  return clamped_volume(box.size, problem.least_size);
}

Quaternion with_z_along(const Vector3d& direction) {
  return Quaternion(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction)).normalized();
}

Quaternion principal_axes(const PointSet& points) {
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i < points.count; ++i) mean += points[i];
  mean /= static_cast<double>(points.count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.count; ++i) {
    scatter += (points[i] - mean) * (points[i] - mean).transpose();
  }
  Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  return Quaternion(Eigen::Quaterniond(axes)).normalized();
}

/// Evenly spread over the half sphere (a Fibonacci spiral).
std::vector<Vector3d> cover_of_half_sphere(int count) {
  std::vector<Vector3d> result;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count;
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double radius = std::sqrt(1.0 - z * z);
    result.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return result;
}

/// Directions between the points that are furthest along the 13 axes of a cube's grid.
std::vector<Vector3d> directions_between_extremes(const PointSet& points) {
  std::vector<std::size_t> extremes;
  for (int code = 14; code < 27; ++code) {
    const Vector3d direction(code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1);
    std::size_t low = 0, high = 0;
    for (std::size_t i = 1; i < points.count; ++i) {
      if (direction.dot(points[i]) < direction.dot(points[low])) low = i;
      if (direction.dot(points[i]) > direction.dot(points[high])) high = i;
    }
    extremes.insert(extremes.end(), {low, high});
  }
  std::sort(extremes.begin(), extremes.end());
  extremes.erase(std::unique(extremes.begin(), extremes.end()), extremes.end());
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < extremes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vector3d direction = points[extremes[i]] - points[extremes[j]];
      if (direction.norm() > 0.0) result.push_back(direction.normalized());
    }
  }
  return result;
}

std::vector<Quaternion> starting_rotations(const PointSet& points) {
  std::vector<Quaternion> result;
  const auto add_frame = [&](const Quaternion& frame) {
    const Eigen::Matrix3d axes = frame.toRotationMatrix();
    result.push_back(frame);
    for (int a = 0; a < 2; ++a) result.push_back(with_z_along(axes.col(a)));
  };
  add_frame(Quaternion::Identity());
  add_frame(principal_axes(points));
  for (const Vector3d& direction : directions_between_extremes(points)) {
    result.push_back(with_z_along(direction));
  }
  for (const Vector3d& direction : cover_of_half_sphere(kCover)) {
    result.push_back(with_z_along(direction));
  }
  return result;
}

/// Leaves the `count` smallest boxes, improved, the smallest first.
void descend_best(const Problem& problem, std::size_t count, const TiltSteps& steps,
                  std::vector<Box>& boxes) {
  const auto smaller = [&](const Box& a, const Box& b) {
    return volume_in(problem, a) < volume_in(problem, b);
  };
  std::stable_sort(boxes.begin(), boxes.end(), smaller);
  boxes.resize(std::min(count, boxes.size()));
  for (Box& box : boxes) box = descend(problem.points, box, steps, problem.least_size);
  std::stable_sort(boxes.begin(), boxes.end(), smaller);
}

Box with_sizes_descending(const Box& box) {
  const auto all = equivalent_boxes(box);
  return *std::find_if(all.begin(), all.end(), [](const Box& candidate) {
    return candidate.size.x() >= candidate.size.y() && candidate.size.y() >= candidate.size.z();
  });
}

}  // namespace

std::optional<Box> enclosing_box(std::span<const Vector3d> points,
                                 std::span<const Quaternion> rotations, double minimum_size) {
  const auto problem = make_problem(points, minimum_size, "enclosing_box");
  if (rotations.empty()) throw InvalidArgument("enclosing_box: expected at least one rotation");
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    require_valid(Box{.rotation = rotations[i]}, "enclosing_box: rotation " + std::to_string(i));
  }
  if (!problem) return std::nullopt;
  std::optional<Box> best;
  for (const Quaternion& rotation : rotations) {
    const Box box = box_about(problem->points, rotation.normalized());
    if (!best || volume_in(*problem, box) < volume_in(*problem, *best)) best = box;
  }
  return finished(*problem, *best);
}

std::optional<Box> minimum_volume_yaw_box(std::span<const Vector3d> points, double minimum_size) {
  const auto problem = make_problem(points, minimum_size, "minimum_volume_yaw_box");
  if (!problem) return std::nullopt;
  const Box box = finished(
      *problem, smallest_about(problem->points, Quaternion::Identity(), problem->least_size));
  if (box.size.x() >= box.size.y()) return box;
  const double turned = yaw(box) + 0.5 * std::numbers::pi;
  const double half_turn = turned > 0.5 * std::numbers::pi ? std::numbers::pi : 0.0;
  return make_yaw_box(box.center, {box.size.y(), box.size.x(), box.size.z()}, turned - half_turn);
}

std::optional<Box> minimum_volume_box(std::span<const Vector3d> points, double minimum_size) {
  const auto problem = make_problem(points, minimum_size, "minimum_volume_box");
  if (!problem) return std::nullopt;
  std::vector<Box> boxes;
  for (const Quaternion& rotation : starting_rotations(problem->points)) {
    boxes.push_back(smallest_about(problem->points, rotation, problem->least_size));
  }
  descend_best(*problem, kCoarse, kCoarseSteps, boxes);
  descend_best(*problem, kFine, kFineSteps, boxes);
  return with_sizes_descending(finished(*problem, boxes.front()));
}

Box box_between(const Box& inner, const Box& outer, double share) {
  require_valid(inner, "box_between: inner");
  require_valid(outer, "box_between: outer");
  if (!(share >= 0.0 && share <= 1.0)) {
    throw InvalidArgument("box_between: expected a share in [0, 1], got " + std::to_string(share));
  }
  if (share == 1.0) return outer;
  const Eigen::Matrix3d turn = (outer.rotation.conjugate() * inner.rotation).toRotationMatrix();
  const Vector3d center = outer.rotation.conjugate() * (inner.center - outer.center);
  const Vector3d reach = turn.cwiseAbs() * inner.size / 2;
  const Vector3d half = outer.size / 2;
  const Vector3d start_low = (center - reach).cwiseMax(-half).cwiseMin(half);
  const Vector3d start_high = (center + reach).cwiseMax(-half).cwiseMin(half);
  const Vector3d low = start_low + share * (-half - start_low);
  const Vector3d high = start_high + share * (half - start_high);
  return {.center = outer.center + outer.rotation * ((low + high) / 2),
          .size = (high - low).cwiseMax(kMinimumBoxSize),
          .rotation = outer.rotation};
}

}  // namespace arbox::geometry
