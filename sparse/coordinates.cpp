#include "arbox/sparse/coordinates.h"

#include <algorithm>
#include <bit>
#include <string>

#include "arbox/base/error.h"
#include "arbox/sparse/internal/radix_sort.h"

namespace arbox::sparse {
namespace {

constexpr std::int64_t kWidestAxis = std::int64_t{1} << 20;
constexpr std::int32_t kFarthest = std::int32_t{1} << 30;

int bits_for(std::int64_t extent) { return std::bit_width(static_cast<std::uint64_t>(extent)); }

std::int64_t require_extent(const char* axis, std::int32_t low, std::int32_t high) {
  const std::int64_t extent = std::int64_t{high} - low;
  if (low < -kFarthest || high > kFarthest) {
    throw InvalidArgument(std::string("sparse coordinates: ") + axis + " runs from " +
                          std::to_string(low) + " to " + std::to_string(high) +
                          ", but values beyond +-2^30 are not allowed");
  }
  if (extent < kWidestAxis) return extent;
  throw InvalidArgument(std::string("sparse coordinates: ") + axis + " runs from " +
                        std::to_string(low) + " to " + std::to_string(high) +
                        ", but at most 2^20 voxels an axis are allowed; crop or use larger voxels");
}

}  // namespace

KeyLayout::KeyLayout(const Coordinate& low, const Coordinate& high, std::int32_t margin)
    : low_{low.batch, low.x - margin, low.y - margin, low.z - margin} {
  y_shift_ = bits_for(require_extent("z", low.z, high.z) + 2 * margin);
  x_shift_ = y_shift_ + bits_for(require_extent("y", low.y, high.y) + 2 * margin);
  batch_shift_ = x_shift_ + bits_for(require_extent("x", low.x, high.x) + 2 * margin);
  bits_ = batch_shift_ + bits_for(std::int64_t{high.batch} - low.batch);
  if (bits_ > 63) {
    throw InvalidArgument("sparse coordinates: the extents need keys of " + std::to_string(bits_) +
                          " bits, but 63 are there; use smaller batches or extents");
  }
}

Coordinate KeyLayout::unpack(std::uint64_t key) const {
  const auto value = [&](int shift, int next, std::int32_t low) {
    const std::uint64_t mask = (std::uint64_t{1} << (next - shift)) - 1;
    return static_cast<std::int32_t>(low + static_cast<std::int64_t>((key >> shift) & mask));
  };
  return {value(batch_shift_, 63, low_.batch), value(x_shift_, batch_shift_, low_.x),
          value(y_shift_, x_shift_, low_.y), value(0, y_shift_, low_.z)};
}

CoordinateBounds bounds(std::span<const Coordinate> coordinates) {
  if (coordinates.empty()) return {};
  CoordinateBounds result{coordinates[0], coordinates[0]};
  auto& [low, high] = result;
  for (const Coordinate& c : coordinates) {
    low = {std::min(low.batch, c.batch), std::min(low.x, c.x), std::min(low.y, c.y),
           std::min(low.z, c.z)};
    high = {std::max(high.batch, c.batch), std::max(high.x, c.x), std::max(high.y, c.y),
            std::max(high.z, c.z)};
  }
  return result;
}

SortedCoordinates sort_coordinates(std::span<const Coordinate> coordinates) {
  const auto [low, high] = bounds(coordinates);
  const KeyLayout layout(low, high, 0);
  std::vector<internal::Keyed> keyed(coordinates.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    keyed[i] = {layout.pack(coordinates[i]), static_cast<std::int32_t>(i)};
  }
  internal::radix_sort(keyed, layout.bits());
  SortedCoordinates result;
  result.coordinates.resize(keyed.size());
  result.rows.resize(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    result.rows[i] = keyed[i].row;
    result.coordinates[i] = coordinates[keyed[i].row];
  }
  return result;
}

SortedCoordinates unique_coordinates(std::span<const Coordinate> coordinates) {
  const auto [low, high] = bounds(coordinates);
  const KeyLayout layout(low, high, 0);
  std::vector<std::uint64_t> keys(coordinates.size());
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = layout.pack(coordinates[i]);
  internal::radix_sort(keys, layout.bits());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  SortedCoordinates result;
  result.coordinates.resize(keys.size());
  result.rows.resize(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    result.coordinates[i] = layout.unpack(keys[i]);
    result.rows[i] = static_cast<std::int32_t>(i);
  }
  return result;
}

}  // namespace arbox::sparse
