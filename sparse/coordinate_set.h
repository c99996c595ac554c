#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "arbox/sparse/coordinates.h"

namespace arbox::sparse {

/// One value for each of the axes x, y, z.
using Triple = std::array<std::int32_t, 3>;

/// Where the voxels of a tensor are and what their coordinates mean.
///
/// Unbounded (MinkowskiEngine's way): coordinates of any sign in units of the finest voxel;
/// a tensor of stride s holds multiples of s. Grid-bounded (spconv's way): coordinates are indices
/// 0 <= x < grid[0] (y, z likewise) into the grid of their own level, and stride only tells how
/// many finest voxels a cell spans.
struct Lattice {
  Triple stride{1, 1, 1};
  std::optional<Triple> grid = {};
  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// An immutable set of distinct voxel coordinates, shared by the tensors that live on it.
class CoordinateSet {
 public:
  /// Sorts the coordinates; row i of a tensor on this set is coordinates[i].
  /// Throws InvalidArgument for duplicates (naming both rows), for negative batch numbers, for
  /// coordinates that are no multiples of the stride or outside of the grid, and as KeyLayout does.
  CoordinateSet(std::span<const Coordinate> coordinates, const Lattice& lattice);
  /// Takes coordinates that are sorted, distinct and on the lattice; nothing is checked.
  CoordinateSet(SortedCoordinates sorted, const Lattice& lattice);

  std::int64_t size() const { return static_cast<std::int64_t>(sorted_.rows.size()); }
  const Lattice& lattice() const { return lattice_; }
  /// Sorted order, the order of kernel maps.
  const SortedCoordinates& sorted() const { return sorted_; }
  /// The coordinates in the order of the tensor's rows. O(N).
  std::vector<Coordinate> in_rows() const;
  /// One more than the largest batch number; 0 for an empty set.
  std::int32_t batch_size() const;

 private:
  SortedCoordinates sorted_;
  Lattice lattice_;
};

using CoordinateSetPtr = std::shared_ptr<const CoordinateSet>;

}  // namespace arbox::sparse
