#include "arbox/detectors/cluster_fit/internal/clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace arbox::detectors::internal {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;
// Distances between the boxes of cells decide only where rounding cannot.
constexpr float kRounding = 1e-5f;

struct Cell {
  std::int32_t x, y, z;
  bool operator==(const Cell&) const = default;
};

/// Numbers the cells of a grid in the order in which they are first met.
class CellTable {
 public:
  CellTable() : slots_(1024, Slot{{}, kNone}) {}

  /// The number of the cell; a new one when it is first met.
  std::uint32_t number(const Cell& cell) {
    if (Slot& slot = slots_[place(cell)]; slot.number != kNone) return slot.number;
    if (2 * (cells_.size() + 1) > slots_.size()) grow();
    const auto next = static_cast<std::uint32_t>(cells_.size());
    slots_[place(cell)] = {cell, next};
    cells_.push_back(cell);
    return next;
  }

  /// The number of the cell or kNone.
  std::uint32_t find(const Cell& cell) const { return slots_[place(cell)].number; }

  const std::vector<Cell>& cells() const { return cells_; }

 private:
  struct Slot {
    Cell cell;
    std::uint32_t number;
  };

  std::size_t place(const Cell& cell) const {
    std::uint64_t hash = static_cast<std::uint32_t>(cell.x) * 0x9E3779B97F4A7C15u;
    hash ^= static_cast<std::uint32_t>(cell.y) * 0xC2B2AE3D27D4EB4Fu;
    hash ^= static_cast<std::uint32_t>(cell.z) * 0x165667B19E3779F9u;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = (hash ^ (hash >> 32)) & mask;
    while (slots_[slot].number != kNone && slots_[slot].cell != cell) slot = (slot + 1) & mask;
    return slot;
  }

  void grow() {
    slots_.assign(2 * slots_.size(), Slot{{}, kNone});
    for (std::uint32_t i = 0; i < cells_.size(); ++i) slots_[place(cells_[i])] = {cells_[i], i};
  }

  std::vector<Slot> slots_;
  std::vector<Cell> cells_;
};

Cell cell_of(const Eigen::Vector3f& point, double edge) {
  const auto index = [edge](float x) {
    const double cells = x / edge;
    const auto towards_zero = static_cast<std::int32_t>(cells);
    return towards_zero - (cells < towards_zero ? 1 : 0);
  };
  return {index(point.x()), index(point.y()), index(point.z())};
}

/// Numbers the cell of every point.
std::vector<std::uint32_t> number_cells(std::span<const Eigen::Vector3f> points, double edge,
                                        CellTable& table) {
  std::vector<std::uint32_t> numbers(points.size());
  Cell last = {};
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Cell cell = cell_of(points[i], edge);
    numbers[i] = i > 0 && cell == last ? numbers[i - 1] : table.number(cell);
    last = cell;
  }
  return numbers;
}

/// Items sorted into groups: those of group g are items[start[g]] to items[start[g + 1]].
struct Groups {
  std::vector<std::uint32_t> start, items;

  Groups(const std::vector<std::uint32_t>& group_of, std::size_t groups)
      : start(groups + 1, 0), items(group_of.size()) {
    for (const auto group : group_of) ++start[group + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    for (std::uint32_t i = 0; i < items.size(); ++i) items[next[group_of[i]]++] = i;
  }
  std::span<const std::uint32_t> of(std::uint32_t group) const {
    return {items.data() + start[group], items.data() + start[group + 1]};
  }
};

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

/// Tells whether two cells hold points within the tolerance of each other.
class Contact {
 public:
  Contact(std::span<const Eigen::Vector3f> points, const Groups& members, double tolerance)
      : start_(members.start), limit_(static_cast<float>(tolerance * tolerance)) {
    points_.reserve(points.size());
    for (const auto i : members.items) points_.push_back(points[i].array());
    boxes_.reserve(start_.size() - 1);
    for (std::size_t cell = 0; cell + 1 < start_.size(); ++cell) {
      Extent box{points_[start_[cell]], points_[start_[cell]]};
      for (auto i = start_[cell]; i < start_[cell + 1]; ++i) {
        box = {box.low.min(points_[i]), box.high.max(points_[i])};
      }
      boxes_.push_back(box);
    }
  }

  bool operator()(std::uint32_t one, std::uint32_t other) const {
    const Extent &a = boxes_[one], &b = boxes_[other];
    const Point gap = (a.low - b.high).max(b.low - a.high).max(0.0f);
    if (gap.square().sum() > limit_ * (1.0f + kRounding)) return false;
    const Point reach = (a.high - b.low).max(b.high - a.low);
    if (reach.square().sum() < limit_ * (1.0f - kRounding)) return true;
    for (auto i = start_[one]; i < start_[one + 1]; ++i) {
      const Point& point = points_[i];
      const Point away = (b.low - point).max(point - b.high).max(0.0f);
      if (away.square().sum() > limit_ * (1.0f + kRounding)) continue;
      for (auto j = start_[other]; j < start_[other + 1]; ++j) {
        if ((points_[j] - point).square().sum() <= limit_) return true;
      }
    }
    return false;
  }

 private:
  using Point = Eigen::Array3f;
  struct Extent {
    Point low, high;
  };
  std::span<const std::uint32_t> start_;
  float limit_;
  std::vector<Point> points_;
  std::vector<Extent> boxes_;
};

/// Calls visit(one, other) once for each pair of cells that may hold points within sqrt(3) edges,
/// columns side by side first.
template <class Visit>
void visit_neighbours(const std::vector<Cell>& cells, Visit&& visit) {
  CellTable table;
  std::vector<std::uint32_t> column_of;
  column_of.reserve(cells.size());
  for (const Cell& cell : cells) column_of.push_back(table.number({cell.x, cell.y, 0}));
  Groups columns(column_of, table.cells().size());
  const auto below = [&](auto one, auto other) { return cells[one].z < cells[other].z; };
  for (std::size_t c = 0; c + 1 < columns.start.size(); ++c) {
    std::sort(columns.items.begin() + columns.start[c],
              columns.items.begin() + columns.start[c + 1], below);
  }
  // Half of the columns around; the other half mirrors it.
  constexpr std::array<std::array<int, 2>, 13> kAround = {{{0, 0},
                                                           {0, 1},
                                                           {1, 0},
                                                           {1, -1},
                                                           {1, 1},
                                                           {0, 2},
                                                           {2, 0},
                                                           {1, -2},
                                                           {1, 2},
                                                           {2, -1},
                                                           {2, 1},
                                                           {2, -2},
                                                           {2, 2}}};
  for (const auto& [dx, dy] : kAround) {
    for (std::uint32_t column = 0; column < table.cells().size(); ++column) {
      const Cell& at = table.cells()[column];
      const auto beside = table.find({at.x + dx, at.y + dy, 0});
      if (beside == kNone) continue;
      const auto others = columns.of(beside);
      auto first = others.begin();
      for (const auto one : columns.of(column)) {
        while (first != others.end() && cells[*first].z < cells[one].z - 2) ++first;
        for (auto other = first; other != others.end() && cells[*other].z <= cells[one].z + 2;
             ++other) {
          if (beside != column || one < *other) visit(one, *other);
        }
      }
    }
  }
}

}  // namespace

std::vector<std::uint32_t> thinned(std::span<const Eigen::Vector3f> points, double edge) {
  CellTable table;
  const auto cells = number_cells(points, edge, table);
  std::vector<std::uint32_t> kept;
  kept.reserve(table.cells().size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (cells[i] == kept.size()) kept.push_back(i);
  }
  return kept;
}

std::vector<std::vector<std::uint32_t>> euclidean_clusters(std::span<const Eigen::Vector3f> points,
                                                           double tolerance, int min_points) {
  CellTable table;
  const auto cell_of_point = number_cells(points, tolerance / std::sqrt(3.0) * (1.0 - 1e-5), table);
  const std::size_t cells = table.cells().size();
  const Groups members(cell_of_point, cells);
  const Contact touch(points, members, tolerance);
  DisjointSets sets(cells);
  visit_neighbours(table.cells(), [&](std::uint32_t one, std::uint32_t other) {
    if (sets.find(one) != sets.find(other) && touch(one, other)) sets.unite(one, other);
  });

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
