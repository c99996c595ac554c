#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "arbox/geometry/point_cloud_view.h"

namespace arbox::io::internal {

/// True if a point of the cloud is finite.
bool has_finite_point(const geometry::PointCloudView& cloud);

/// A square seen from above: all points whose x and y are at most `reach` from the middle (metres).
struct Square {
  double x = 0.0, y = 0.0, reach = 0.0;
};

/// Points in square cells seen from above, so that a box looks at few of them. Points that are not
/// finite are left out.
class PointGrid {
 public:
  /// Of all points.
  explicit PointGrid(const geometry::PointCloudView& cloud);
  /// Of the points in the squares and of some around them; costs little for points far away.
  PointGrid(const geometry::PointCloudView& cloud, std::span<const Square> squares);

  bool empty() const { return points_.empty(); }
  /// Calls visit(point) for the points of all cells that touch the square.
  template <class Visit>
  void each_near(const Square& square, Visit&& visit) const {
    if (empty()) return;
    const auto [x, y, reach] = square;
    const auto range = [](double low, double origin, double scale, int cells) {
      return static_cast<int>(std::clamp(std::floor((low - origin) * scale), -1.0, 1.0 * cells));
    };
    const int left = std::max(0, range(x - reach, origin_.x(), scale_, columns_));
    const int right = std::min(columns_ - 1, range(x + reach, origin_.x(), scale_, columns_));
    const int top = std::max(0, range(y - reach, origin_.y(), scale_, rows_));
    const int bottom = std::min(rows_ - 1, range(y + reach, origin_.y(), scale_, rows_));
    for (int row = top; row <= bottom && left <= right; ++row) {
      const std::size_t first = static_cast<std::size_t>(row) * columns_;
      for (std::size_t i = starts_[first + left]; i < starts_[first + right + 1]; ++i) {
        visit(points_[i]);
      }
    }
  }

 private:
  void sort(const std::vector<Eigen::Vector3f>& finite);

  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double scale_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::size_t> starts_;
  std::vector<Eigen::Vector3f> points_;
};

}  // namespace arbox::io::internal
