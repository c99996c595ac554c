#include "arbox/sparse/coordinate_set.h"

#include <algorithm>
#include <string>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::sparse {
namespace {

std::string to_text(const Coordinate& c) {
  return "(" + std::to_string(c.batch) + ", " + std::to_string(c.x) + ", " + std::to_string(c.y) +
         ", " + std::to_string(c.z) + ")";
}

void require_on_lattice(std::span<const Coordinate> coordinates, const Lattice& lattice) {
  for (const std::int32_t stride : lattice.stride) {
    if (stride < 1) throw InvalidArgument("CoordinateSet: strides must be at least 1");
  }
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const Coordinate& c = coordinates[i];
    const Triple position{c.x, c.y, c.z};
    bool fits = c.batch >= 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (lattice.grid) {
        fits = fits && position[axis] >= 0 && position[axis] < (*lattice.grid)[axis];
      } else {
        fits = fits && position[axis] % lattice.stride[axis] == 0;
      }
    }
    if (!fits) {
      throw InvalidArgument(
          "CoordinateSet: row " + std::to_string(i) + " " + to_text(c) +
          (lattice.grid ? " is outside of the grid" : " is not a multiple of the stride") +
          " or has a negative batch number");
    }
  }
}

}  // namespace

CoordinateSet::CoordinateSet(std::span<const Coordinate> coordinates, const Lattice& lattice)
    : lattice_(lattice) {
  require_on_lattice(coordinates, lattice);
  sorted_ = sort_coordinates(coordinates);
  const auto& all = sorted_.coordinates;
  const auto twin = std::adjacent_find(all.begin(), all.end());
  if (twin != all.end()) {
    const auto at = twin - all.begin();
    throw InvalidArgument("CoordinateSet: rows " + std::to_string(sorted_.rows[at]) + " and " +
                          std::to_string(sorted_.rows[at + 1]) + " are the same voxel " +
                          to_text(*twin) + "; merge them first (voxelize)");
  }
}

CoordinateSet::CoordinateSet(SortedCoordinates sorted, const Lattice& lattice)
    : sorted_(std::move(sorted)), lattice_(lattice) {}

std::vector<Coordinate> CoordinateSet::in_rows() const {
  std::vector<Coordinate> result(sorted_.rows.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[sorted_.rows[i]] = sorted_.coordinates[i];
  return result;
}

std::int32_t CoordinateSet::batch_size() const {
  return sorted_.coordinates.empty() ? 0 : sorted_.coordinates.back().batch + 1;
}

}  // namespace arbox::sparse
