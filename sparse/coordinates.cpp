#include "arbox/sparse/coordinates.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::sparse {
namespace {

constexpr std::int64_t kWidestAxis = std::int64_t{1} << 20;
constexpr int kDigitBits = 11;

struct Keyed {
  std::uint64_t key;
  std::int32_t row;
};

int bits_for(std::int64_t extent) { return std::bit_width(static_cast<std::uint64_t>(extent)); }

std::int64_t require_extent(const char* axis, std::int32_t low, std::int32_t high) {
  const std::int64_t extent = std::int64_t{high} - low;
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
  std::vector<Keyed> keyed(coordinates.size());
  bool sorted = true;
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    keyed[i] = {layout.pack(coordinates[i]), static_cast<std::int32_t>(i)};
    sorted = sorted && (i == 0 || keyed[i - 1].key <= keyed[i].key);
  }
  std::vector<Keyed> other(sorted ? 0 : keyed.size());
  for (int shift = 0; !sorted && shift < layout.bits(); shift += kDigitBits) {
    std::array<std::uint32_t, (1 << kDigitBits)> starts{};
    constexpr std::uint64_t mask = (1 << kDigitBits) - 1;
    for (const Keyed& item : keyed) ++starts[(item.key >> shift) & mask];
    std::uint32_t sum = 0;
    for (std::uint32_t& start : starts) sum += std::exchange(start, sum);
    for (const Keyed& item : keyed) other[starts[(item.key >> shift) & mask]++] = item;
    keyed.swap(other);
  }
  SortedCoordinates result;
  result.coordinates.resize(keyed.size());
  result.rows.resize(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    result.rows[i] = keyed[i].row;
    result.coordinates[i] = coordinates[keyed[i].row];
  }
  return result;
}

}  // namespace arbox::sparse
