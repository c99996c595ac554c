#include "arbox/geometry/internal/near_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace arbox::geometry::internal {

NearGrid::NearGrid(std::size_t capacity, double cell)
    : scale_(1.0 / cell), heads_(std::bit_ceil(4 * capacity + 16), -1) {
  entries_.reserve(4 * capacity);
}

void NearGrid::insert(std::int32_t item, double x, double y, double radius) {
  items_.push_back(item);
  const Range range = cells_of(x, y, radius);
  if (range.count() > kMostCells) {
    large_.push_back(item);
    return;
  }
  for (double cx = range.low_x; cx <= range.high_x; ++cx) {
    for (double cy = range.low_y; cy <= range.high_y; ++cy) {
      std::int32_t& head = heads_[bucket(cx, cy)];
      entries_.push_back({cx, cy, range.low_x, range.low_y, item, head});
      head = static_cast<std::int32_t>(entries_.size() - 1);
    }
  }
}

NearGrid::Range NearGrid::cells_of(double x, double y, double radius) const {
  // Beyond this, neighbouring whole numbers are no longer distinct doubles: one cell for all.
  constexpr double kLargest = 1e15;
  const auto cell = [&](double position) {
    return std::clamp(std::floor(position * scale_), -kLargest, kLargest);
  };
  return {cell(x - radius), cell(y - radius), cell(x + radius), cell(y + radius)};
}

std::size_t NearGrid::bucket(double cx, double cy) const {
  const auto x = static_cast<std::uint64_t>(static_cast<std::int64_t>(cx));
  const auto y = static_cast<std::uint64_t>(static_cast<std::int64_t>(cy));
  const std::uint64_t mixed = (x * 0x9E3779B97F4A7C15u) ^ (y * 0xC2B2AE3D27D4EB4Fu);
  return (mixed ^ (mixed >> 29)) & (heads_.size() - 1);
}

}  // namespace arbox::geometry::internal
