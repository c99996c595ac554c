#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "arbox/geometry/internal/near_grid.h"
#include "arbox/geometry/internal/overlap_engine.h"
#include "arbox/geometry/nms.h"

namespace arbox::geometry::internal {

/// The boxes of one suppression, best score first, prepared for overlap.
class Candidates {
 public:
  /// Throws what nms() documents.
  Candidates(std::span<const Box> boxes, std::span<const double> scores,
             std::span<const int> classes, const NmsOptions& options);

  std::int32_t size() const { return static_cast<std::int32_t>(order_.size()); }
  /// Index in the caller's arrays.
  std::int64_t original(std::int32_t i) const { return order_[i]; }
  double score(std::int32_t i) const { return scores_[i]; }
  const OverlapBox& box(std::int32_t i) const { return boxes_->operator[](i); }

  NearGrid make_grid() const;
  void insert(NearGrid& grid, std::int32_t i) const {
    const OverlapBounds disc = boxes_->bounds(i);
    grid.insert(i, *disc.x, *disc.y, *disc.radius);
  }
  /// Calls visit(j) for those in the grid whose IoU with i may be above the threshold.
  template <class Visit>
  void visit_rivals(const NearGrid& grid, std::int32_t i, double threshold,
                    const Visit& visit) const {
    const OverlapBounds disc = boxes_->bounds(i);
    grid.visit_near(*disc.x, *disc.y, *disc.radius, [&](std::int32_t j) {
      if (may_exceed(i, j, threshold)) visit(j);
    });
  }

  double squared_distance(std::int32_t i, std::int32_t j) const;

 private:
  bool may_exceed(std::int32_t i, std::int32_t j, double threshold) const;

  std::vector<std::int64_t> order_;
  std::vector<double> scores_;
  /// Empty unless classes count.
  std::vector<int> classes_;
  std::optional<OverlapBoxes> boxes_;
};

/// nms() for options.soft other than `none`.
NmsResult soft_nms(const Candidates& candidates, const NmsOptions& options);

}  // namespace arbox::geometry::internal
