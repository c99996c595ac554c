#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace arbox::geometry::internal {

/// Discs in the plane, found by their neighbourhood: a hashed grid of square cells. Discs much
/// larger than a cell are kept apart, so that no input makes it slow to fill.
class NearGrid {
 public:
  /// `capacity`: discs that will be inserted, about. `cell` > 0: edge of a cell, best the diameter
  /// of a usual disc.
  NearGrid(std::size_t capacity, double cell);

  void insert(std::int32_t item, double x, double y, double radius);

  /// Calls visit(item) once for each disc whose cells meet those of the given one: all that it
  /// touches, and some more.
  template <class Visit>
  void visit_near(double x, double y, double radius, const Visit& visit) const {
    const Range range = cells_of(x, y, radius);
    if (range.count() > kMostCells) {
      for (const std::int32_t item : items_) visit(item);
      return;
    }
    for (const std::int32_t item : large_) visit(item);
    for (double cx = range.low_x; cx <= range.high_x; ++cx) {
      for (double cy = range.low_y; cy <= range.high_y; ++cy) {
        for (std::int32_t e = heads_[bucket(cx, cy)]; e >= 0; e = entries_[e].next) {
          const Entry& entry = entries_[e];
          // Of the cells that the two share, only the lowest reports the pair.
          if (entry.x == cx && entry.y == cy && cx == std::max(range.low_x, entry.low_x) &&
              cy == std::max(range.low_y, entry.low_y)) {
            visit(entry.item);
          }
        }
      }
    }
  }

 private:
  static constexpr double kMostCells = 64;

  /// Whole numbers, as doubles so that no coordinate overflows.
  struct Range {
    double low_x, low_y, high_x, high_y;
    double count() const { return (high_x - low_x + 1) * (high_y - low_y + 1); }
  };
  struct Entry {
    double x, y, low_x, low_y;
    std::int32_t item, next;
  };

  Range cells_of(double x, double y, double radius) const;
  std::size_t bucket(double cx, double cy) const;

  double scale_;
  std::vector<std::int32_t> heads_;
  std::vector<Entry> entries_;
  std::vector<std::int32_t> items_, large_;
};

}  // namespace arbox::geometry::internal
