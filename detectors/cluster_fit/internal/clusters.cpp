#include "arbox/detectors/cluster_fit/internal/clusters.h"

#include <array>
#include <bit>
#include <cmath>
#include <numeric>

namespace arbox::detectors::internal {
namespace {

using Cell = std::array<std::int32_t, 3>;

constexpr std::uint32_t kNone = 0xffffffff;

/// Numbers the cells of a grid in the order in which they are first met.
class CellTable {
 public:
  explicit CellTable(std::size_t expected)
      : mask_(std::bit_ceil(2 * expected + 16) - 1), slots_(mask_ + 1, kNone) {}

  /// The number of the cell; a new one when it is first met.
  std::uint32_t number(const Cell& cell) {
    std::size_t slot = find_slot(cell);
    if (slots_[slot] == kNone) {
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
      cells_.push_back(cell);
    }
    return slots_[slot];
  }

  /// The number of the cell or kNone.
  std::uint32_t find(const Cell& cell) const { return slots_[find_slot(cell)]; }

  const std::vector<Cell>& cells() const { return cells_; }

 private:
  std::size_t find_slot(const Cell& cell) const {
    std::uint64_t hash = static_cast<std::uint32_t>(cell[0]) * 0x9E3779B97F4A7C15u;
    hash ^= static_cast<std::uint32_t>(cell[1]) * 0xC2B2AE3D27D4EB4Fu;
    hash ^= static_cast<std::uint32_t>(cell[2]) * 0x165667B19E3779F9u;
    std::size_t slot = (hash ^ (hash >> 32)) & mask_;
    while (slots_[slot] != kNone && cells_[slots_[slot]] != cell) slot = (slot + 1) & mask_;
    return slot;
  }

  std::size_t mask_;
  std::vector<std::uint32_t> slots_;
  std::vector<Cell> cells_;
};

Cell cell_of(const Eigen::Vector3f& point, double edge) {
  Cell cell;
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<std::int32_t>(std::floor(point[axis] / edge));
  }
  return cell;
}

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t item) {
    while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
    return item;
  }
  void unite(std::uint32_t one, std::uint32_t other) { parent_[find(one)] = find(other); }

 private:
  std::vector<std::uint32_t> parent_;
};

// Half of the cells that may hold a point within sqrt(3) edges; the other half mirrors it.
std::vector<Cell> half_neighbourhood() {
  std::vector<Cell> offsets;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) {
        if (Cell{x, y, z} > Cell{0, 0, 0}) offsets.push_back({x, y, z});
      }
    }
  }
  return offsets;
}

}  // namespace

std::vector<std::uint32_t> thinned(std::span<const Eigen::Vector3f> points, double edge) {
  CellTable table(points.size());
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (table.number(cell_of(points[i], edge)) == kept.size()) kept.push_back(i);
  }
  return kept;
}

std::vector<std::vector<std::uint32_t>> euclidean_clusters(std::span<const Eigen::Vector3f> points,
                                                           double tolerance, int min_points) {
  const double edge = tolerance / std::sqrt(3.0) * (1.0 - 1e-5);
  CellTable table(points.size());
  std::vector<std::uint32_t> cell_of_point(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    cell_of_point[i] = table.number(cell_of(points[i], edge));
  }
  const std::size_t cells = table.cells().size();
  std::vector<std::uint32_t> start(cells + 1, 0), members(points.size());
  for (const auto cell : cell_of_point) ++start[cell + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
  for (std::uint32_t i = 0; i < points.size(); ++i) members[next[cell_of_point[i]]++] = i;

  const auto limit = static_cast<float>(tolerance * tolerance);
  const auto touch = [&](std::uint32_t one, std::uint32_t other) {
    for (std::uint32_t i = start[one]; i < start[one + 1]; ++i) {
      const Eigen::Vector3f& point = points[members[i]];
      for (std::uint32_t j = start[other]; j < start[other + 1]; ++j) {
        if ((points[members[j]] - point).squaredNorm() <= limit) return true;
      }
    }
    return false;
  };
  const std::vector<Cell> offsets = half_neighbourhood();
  DisjointSets sets(cells);
  for (std::uint32_t cell = 0; cell < cells; ++cell) {
    const Cell& at = table.cells()[cell];
    for (const Cell& offset : offsets) {
      const auto other = table.find({at[0] + offset[0], at[1] + offset[1], at[2] + offset[2]});
      if (other == kNone || sets.find(cell) == sets.find(other)) continue;
      if (touch(cell, other)) sets.unite(cell, other);
    }
  }

  std::vector<std::uint32_t> size(cells, 0), cluster_of(cells, kNone);
  for (const auto cell : cell_of_point) ++size[sets.find(cell)];
  std::vector<std::vector<std::uint32_t>> clusters;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::uint32_t root = sets.find(cell_of_point[i]);
    if (size[root] < static_cast<std::uint32_t>(min_points)) continue;
    if (cluster_of[root] == kNone) {
      cluster_of[root] = static_cast<std::uint32_t>(clusters.size());
      clusters.emplace_back().reserve(size[root]);
    }
    clusters[cluster_of[root]].push_back(i);
  }
  return clusters;
}

}  // namespace arbox::detectors::internal
