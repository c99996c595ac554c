#include "arbox/io/internal/point_grid.h"

#include <Eigen/Geometry>
#include <cstdint>

namespace arbox::io::internal {
namespace {

constexpr double kCell = 1.0;
constexpr double kMostCells = 512.0;

}  // namespace

PointGrid::PointGrid(const geometry::PointCloudView& cloud) {
  Eigen::AlignedBox2f extent;
  std::vector<Eigen::Vector3f> finite;
  finite.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point = cloud.position(i);
    if (!point.allFinite()) continue;
    extent.extend(point.head<2>());
    finite.push_back(point);
  }
  if (finite.empty()) return;
  origin_ = extent.min().cast<double>();
  const double largest = (extent.max() - extent.min()).cast<double>().maxCoeff();
  scale_ = 1.0 / std::max(kCell, largest / kMostCells);
  const auto cells = [&](int axis) {
    return static_cast<int>((static_cast<double>(extent.max()[axis]) - origin_[axis]) * scale_) + 1;
  };
  columns_ = cells(0);
  rows_ = cells(1);
  std::vector<std::uint32_t> cell(finite.size());
  starts_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  for (std::size_t i = 0; i < finite.size(); ++i) {
    const auto column = static_cast<std::uint32_t>((finite[i].x() - origin_.x()) * scale_);
    const auto row = static_cast<std::uint32_t>((finite[i].y() - origin_.y()) * scale_);
    cell[i] = std::min<std::uint32_t>(row, rows_ - 1) * columns_ +
              std::min<std::uint32_t>(column, columns_ - 1);
    ++starts_[cell[i] + 1];
  }
  for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  points_.resize(finite.size());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < finite.size(); ++i) points_[next[cell[i]]++] = finite[i];
}

}  // namespace arbox::io::internal
