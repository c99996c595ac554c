#include "arbox/geometry/internal/overlap_engine.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "arbox/base/error.h"

namespace arbox::geometry {

OverlapKernels overlap_kernels(SimdLevel level) {
  switch (level) {
    case SimdLevel::kAvx512:
      return {avx512::near_bounds, avx512::level_intersections, avx512::free_intersections};
    case SimdLevel::kAvx2:
      return {avx2::near_bounds, avx2::level_intersections, avx2::free_intersections};
    case SimdLevel::kScalar:
      break;
  }
  return {scalar::near_bounds, scalar::level_intersections, scalar::free_intersections};
}

namespace internal {
namespace {

// A tilt that moves no volume of a box up to a million times longer than thick by more than 1e-9.
constexpr double kLevelTilt = 1e-15;
// Rotations that were kept in float32 are still yaw-only to the bird.
constexpr double kBirdsEyeTilt = 1e-6;
constexpr double kSmallest = 1e-40;
constexpr double kLargest = 1e40;

Eigen::Matrix3d heading_only(const Eigen::Matrix3d& rotation) {
  const Eigen::Vector2d heading = rotation.col(0).head<2>().normalized();
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() << heading.x(), -heading.y(), heading.y(), heading.x();
  return result;
}

double measured(double intersection, double first, double second, Overlap measure) {
  const double volume = std::clamp(intersection, 0.0, std::min(first, second));
  switch (measure) {
    case Overlap::kIntersection:
      return volume;
    case Overlap::kIou:
      return volume / std::max({first, second, first + second - volume});
    case Overlap::kIog:
      return volume / second;
  }
  return volume;
}

}  // namespace

OverlapBox prepared(const Box& box, OverlapSpace space) {
  Eigen::Vector3d center = box.center, half = 0.5 * box.size;
  Eigen::Matrix3d rotation = box.rotation.normalized().toRotationMatrix();
  OverlapBox result;
  result.level = space != OverlapSpace::k3d || is_yaw_only(box, kLevelTilt);
  if (space == OverlapSpace::kAxisAligned) {
    rotation.setIdentity();
  } else if (result.level) {
    rotation = heading_only(rotation);
  }
  if (space == OverlapSpace::kBirdsEye) {
    center.z() = 0.0;
    half.z() = 0.5;
  }
  result.volume = 8.0 * half.prod();
  Eigen::Map<Eigen::Vector3d>(result.center) = center;
  Eigen::Map<Eigen::Vector3d>(result.half) = half;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(result.rotation) = rotation;
  return result;
}

Bound bound(const OverlapBox& box) {
  // Room for rounding, so that no pair is dropped that meets.
  constexpr double kSlack = 1.0 + 1e-12;
  const Eigen::Map<const Eigen::Vector3d> half(box.half);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(box.rotation);
  const double radius = box.level ? half.head<2>().norm() : half.norm();
  const double reach = rotation.row(2).cwiseAbs().dot(half);
  return {box.center[0], box.center[1], box.center[2], radius * kSlack, reach * kSlack};
}

void require_measurable(std::span<const Box> boxes, OverlapSpace space, std::string_view where) {
  require_valid(boxes, where);
  for (std::size_t row = 0; row < boxes.size(); ++row) {
    const Eigen::Vector3d& size = boxes[row].size;
    const bool too_small_or_large = size.minCoeff() < kSmallest || size.maxCoeff() > kLargest;
    const bool tilted = space == OverlapSpace::kBirdsEye && !is_yaw_only(boxes[row], kBirdsEyeTilt);
    if (!too_small_or_large && !tilted) continue;
    std::ostringstream problem;
    problem << where << ": box in row " << row << ": ";
    if (too_small_or_large) {
      problem << "sizes must lie in [1e-40, 1e40] m, got " << size.transpose();
    } else {
      problem << "bird's-eye overlap asks for rotations about +z, got the quaternion "
              << boxes[row].rotation.coeffs().transpose()
              << " (x y z w); use the overlap in full 3-D, or the boxes' yaw alone";
    }
    throw InvalidArgument(problem.str());
  }
}

OverlapBoxes::OverlapBoxes(std::span<const Box> boxes, OverlapSpace space) {
  boxes_.reserve(boxes.size());
  for (std::vector<double>* column : {&x_, &y_, &z_, &radius_, &reach_}) {
    column->reserve(boxes.size());
  }
  for (const Box& box : boxes) {
    boxes_.push_back(prepared(box, space));
    const Bound cylinder = bound(boxes_.back());
    x_.push_back(cylinder.x);
    y_.push_back(cylinder.y);
    z_.push_back(cylinder.z);
    radius_.push_back(cylinder.radius);
    reach_.push_back(cylinder.reach);
  }
}

void PairBatch::add(const OverlapBox& first, const OverlapBox& second, double* target) {
  const bool both_level = first.level && second.level;
  Pairs& pairs = both_level ? level_ : free_;
  pairs.first[pairs.count] = &first;
  pairs.second[pairs.count] = &second;
  pairs.target[pairs.count] = target;
  if (++pairs.count == kCapacity) flush(pairs, both_level ? kernels_.level : kernels_.free);
}

void PairBatch::flush() {
  flush(level_, kernels_.level);
  flush(free_, kernels_.free);
}

void PairBatch::flush(Pairs& pairs, decltype(OverlapKernels::level) kernel) const {
  if (pairs.count == 0) return;
  std::array<double, kCapacity> volumes;
  kernel(pairs.first.data(), pairs.second.data(), pairs.count, volumes.data());
  for (int i = 0; i < pairs.count; ++i) {
    *pairs.target[i] =
        measured(volumes[i], pairs.first[i]->volume, pairs.second[i]->volume, measure_);
  }
  pairs.count = 0;
}

}  // namespace internal
}  // namespace arbox::geometry
