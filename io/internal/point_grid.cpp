#include "arbox/io/internal/point_grid.h"

#include <Eigen/Geometry>
#include <cstdint>

namespace arbox::io::internal {
namespace {

constexpr double kCell = 1.0;
constexpr double kMostCells = 512.0;
// A byte a cell: what is asked for every point stays in the first-level cache.
constexpr float kMostMapCells = 128.0F;
constexpr double kFarthest = 1e30;
constexpr double kRounding = 1e-6;

/// Which cells touch a square, with a ring of cells around them that do not. The same float
/// arithmetic for squares and points, which keeps order, after squares have grown by more than
/// their rounding: no finite point in a square is missed.
class SquareMap {
 public:
  explicit SquareMap(std::span<const Square> squares) {
    Eigen::AlignedBox2f extent;
    for (const Square& square : squares) extent.extend(rounded(square));
    if (extent.isEmpty()) return;
    low_ = extent.min();
    scale_ = 1.0F / std::max(static_cast<float>(kCell), extent.sizes().maxCoeff() / kMostMapCells);
    cells_ = ((extent.max() - low_).array() * scale_).floor() + 1.0F;
    width_ = static_cast<std::int32_t>(cells_.x()) + 2;
    touched_.assign(width_ * (static_cast<std::size_t>(cells_.y()) + 2), 0);
    for (const Square& square : squares) touch(rounded(square));
  }

  bool may_hold(const Eigen::Vector3f& point) const {
    return touched_[row(point.y()) * width_ + column(point.x())] != 0;
  }

 private:
  static Eigen::AlignedBox2f rounded(const Square& square) {
    const Eigen::Array2d middle(square.x, square.y);
    const Eigen::Array2d reach = square.reach + kRounding * (middle.abs() + square.reach);
    const auto to_float = [](const Eigen::Array2d& corner) -> Eigen::Vector2f {
      return corner.max(-kFarthest).min(kFarthest).cast<float>();
    };
    return {to_float(middle - reach), to_float(middle + reach)};
  }

  static std::size_t bounded(float cell, float cells) {
    cell = cell > -1.0F ? cell : -1.0F;
    cell = cell < cells ? cell : cells;
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(cell + 1.0F));
  }
  std::size_t column(float x) const { return bounded((x - low_.x()) * scale_, cells_.x()); }
  std::size_t row(float y) const { return bounded((y - low_.y()) * scale_, cells_.y()); }

  void touch(const Eigen::AlignedBox2f& square) {
    const std::size_t left = column(square.min().x()), right = column(square.max().x());
    for (std::size_t r = row(square.min().y()); r <= row(square.max().y()); ++r) {
      for (std::size_t c = left; c <= right; ++c) touched_[r * width_ + c] = 1;
    }
  }

  Eigen::Vector2f low_ = Eigen::Vector2f::Zero();
  float scale_ = 1.0F;
  Eigen::Array2f cells_ = Eigen::Array2f::Zero();
  std::size_t width_ = 2;
  std::vector<std::uint8_t> touched_ = std::vector<std::uint8_t>(4);
};

}  // namespace

bool has_finite_point(const geometry::PointCloudView& cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.position(i).allFinite()) return true;
  }
  return false;
}

PointGrid::PointGrid(const geometry::PointCloudView& cloud) {
  std::vector<Eigen::Vector3f> finite;
  finite.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point = cloud.position(i);
    if (point.allFinite()) finite.push_back(point);
  }
  sort(finite);
}

PointGrid::PointGrid(const geometry::PointCloudView& cloud, std::span<const Square> squares) {
  const SquareMap map(squares);
  std::vector<Eigen::Vector3f> finite;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point = cloud.position(i);
    if (map.may_hold(point) && point.allFinite()) finite.push_back(point);
  }
  sort(finite);
}

void PointGrid::sort(const std::vector<Eigen::Vector3f>& finite) {
  if (finite.empty()) return;
  Eigen::AlignedBox2f extent;
  for (const Eigen::Vector3f& point : finite) extent.extend(point.head<2>());
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
