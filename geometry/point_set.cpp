#include "arbox/geometry/internal/point_set.h"

#include <algorithm>
#include <limits>

#include "arbox/geometry/internal/point_kernels.h"

namespace arbox::geometry::internal {

namespace scalar {
extern const PointKernels kPointKernels;
}
namespace avx2 {
extern const PointKernels kPointKernels;
}
namespace avx512 {
extern const PointKernels kPointKernels;
}

const PointKernels& point_kernels(SimdLevel level) {
  switch (level) {
    case SimdLevel::kAvx512:
      return avx512::kPointKernels;
    case SimdLevel::kAvx2:
      return avx2::kPointKernels;
    case SimdLevel::kScalar:
      break;
  }
  return scalar::kPointKernels;
}

void PointSet::reserve(std::size_t expected) {
  for (auto* axis : {&x, &y, &z}) axis->reserve(expected + kPointPadding);
}

void PointSet::pad() {
  count = x.size();
  const std::size_t padded = (count + kPointPadding - 1) / kPointPadding * kPointPadding;
  for (auto* axis : {&x, &y, &z}) {
    if (count > 0) axis->resize(padded, axis->front());
  }
}

Extents empty_extents() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {kInfinity, kInfinity, kInfinity, -kInfinity, -kInfinity, -kInfinity};
}

RotationRows rows_of(const Quaternion& rotation) {
  RotationRows rows;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data()) =
      rotation.toRotationMatrix().transpose();
  return rows;
}

void widen(const PointSet& points, std::span<const RotationRows> rotations,
           std::span<Extents> extents) {
  if (points.x.empty() || rotations.empty()) return;
  point_kernels(simd_level())
      .extents(points.x.data(), points.y.data(), points.z.data(), points.x.size(),
               rotations.front().data(), rotations.size(), extents.front().data());
}

Eigen::Vector3d size_of(const Extents& extents) {
  return {extents[3] - extents[0], extents[4] - extents[1], extents[5] - extents[2]};
}

Box box_of(const Extents& extents, const Quaternion& rotation, const Eigen::Vector3d& origin) {
  const Eigen::Vector3d middle(0.5 * (extents[0] + extents[3]), 0.5 * (extents[1] + extents[4]),
                               0.5 * (extents[2] + extents[5]));
  return {.center = origin + rotation * middle, .size = size_of(extents), .rotation = rotation};
}

std::size_t least_volume(std::span<const Extents> extents) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < extents.size(); ++r) {
    const double volume = size_of(extents[r]).prod();
    if (volume < least) {
      least = volume;
      best = r;
    }
  }
  return best;
}

}  // namespace arbox::geometry::internal
