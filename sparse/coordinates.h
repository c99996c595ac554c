#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace arbox::sparse {

/// An integer voxel coordinate: one row of an (N, 4) int32 tensor. Any sign. Ordered by batch, x,
/// y, z.
struct Coordinate {
  std::int32_t batch = 0, x = 0, y = 0, z = 0;
  friend auto operator<=>(const Coordinate&, const Coordinate&) = default;
};

/// Coordinates in the order (batch, x, y, z), with the place where each came from.
struct SortedCoordinates {
  std::vector<Coordinate> coordinates;
  /// rows[i] is the caller's row of coordinates[i].
  std::vector<std::int32_t> rows;
};

/// How coordinates are packed into 64-bit keys whose order is the order of the coordinates.
///
/// Fields are as wide as the extents need, so that 2^20 voxels an axis fit with batches of 8.
class KeyLayout {
 public:
  /// Covers `low` to `high`, both ends included, and `margin` voxels beyond on the three axes.
  /// Throws InvalidArgument if an axis is wider than 2^20 voxels, a value beyond +-2^30 or the key
  /// wider than 63 bits.
  KeyLayout(const Coordinate& low, const Coordinate& high, std::int32_t margin);

  std::uint64_t pack(const Coordinate& c) const {
    return (field(c.batch, low_.batch) << batch_shift_) | (field(c.x, low_.x) << x_shift_) |
           (field(c.y, low_.y) << y_shift_) | field(c.z, low_.z);
  }
  /// The coordinate that pack() turns into `key`.
  Coordinate unpack(std::uint64_t key) const;
  /// The difference of the keys of two coordinates that differ by (dx, dy, dz).
  std::int64_t delta(std::int32_t dx, std::int32_t dy, std::int32_t dz) const {
    return (std::int64_t{dx} << x_shift_) + (std::int64_t{dy} << y_shift_) + dz;
  }
  /// Bits that keys use.
  int bits() const { return bits_; }

 private:
  static std::uint64_t field(std::int32_t value, std::int32_t low) {
    return static_cast<std::uint64_t>(std::int64_t{value} - low);
  }

  Coordinate low_;
  int y_shift_ = 0, x_shift_ = 0, batch_shift_ = 0, bits_ = 0;
};

/// Smallest and largest value of each field; both all zero for no coordinates.
struct CoordinateBounds {
  Coordinate low, high;
};
CoordinateBounds bounds(std::span<const Coordinate> coordinates);

/// Sorts by least-significant-digit radix sort: O(N) time, 24 N bytes of scratch memory. Equal
/// coordinates keep their order. Throws as KeyLayout does.
SortedCoordinates sort_coordinates(std::span<const Coordinate> coordinates);

/// The distinct coordinates in sorted order; rows are 0, 1, 2, ... Throws as KeyLayout does.
SortedCoordinates unique_coordinates(std::span<const Coordinate> coordinates);

}  // namespace arbox::sparse
