#include "arbox/training/points_in_boxes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace arbox::training {
namespace {

using geometry::Box;
using geometry::PointCloud;
using Rectangle = Eigen::AlignedBox2d;

/// The boxes by the ground that they may cover, in square cells.
class BoxesByPlace {
 public:
  explicit BoxesByPlace(std::span<const Box> boxes) : boxes_(boxes) {
    for (const Box& box : boxes) area_.extend(reach(box));
    if (boxes.empty()) return;
    const Eigen::Vector2d extent = area_.sizes();
    cell_ = std::max(kCell, extent.maxCoeff() / kMostCells);
    across_ = (extent / cell_).cast<std::ptrdiff_t>() + Eigen::Vector2<std::ptrdiff_t>::Ones();
    cells_.resize(static_cast<std::size_t>(across_.prod()));
    for (std::size_t i = 0; i < boxes.size(); ++i) insert(i);
  }

  /// Calls visit(i) for every box i that holds the point.
  template <class Visit>
  void visit_holders(const float* point, const Visit& visit) const {
    const Eigen::Vector3d p(point[0], point[1], point[2]);
    if (!p.allFinite() || !area_.contains(p.head<2>())) return;
    for (const std::size_t i : cells_[cell_of(p.head<2>())]) {
      if (geometry::contains(boxes_[i], p)) visit(i);
    }
  }

 private:
  static constexpr double kCell = 2.0, kMostCells = 512;

  /// Room for rounding included.
  static Rectangle reach(const Box& box) {
    const Eigen::Vector3d half = box.rotation.toRotationMatrix().cwiseAbs() * (0.5 * box.size) +
                                 Eigen::Vector3d(1, 1, 1) * 1e-3;
    return {box.center.head<2>() - half.head<2>(), box.center.head<2>() + half.head<2>()};
  }

  Eigen::Vector2<std::ptrdiff_t> place_of(const Eigen::Vector2d& point) const {
    return ((point - area_.min()) / cell_).cast<std::ptrdiff_t>();
  }

  std::size_t cell_of(const Eigen::Vector2d& point) const {
    const auto place = place_of(point);
    return static_cast<std::size_t>(place.y() * across_.x() + place.x());
  }

  void insert(std::size_t i) {
    const Rectangle rectangle = reach(boxes_[i]);
    const auto low = place_of(rectangle.min()), high = place_of(rectangle.max());
    for (std::ptrdiff_t y = low.y(); y <= high.y(); ++y) {
      for (std::ptrdiff_t x = low.x(); x <= high.x(); ++x) {
        cells_[static_cast<std::size_t>(y * across_.x() + x)].push_back(i);
      }
    }
  }

  std::span<const Box> boxes_;
  Rectangle area_;
  double cell_ = kCell;
  Eigen::Vector2<std::ptrdiff_t> across_{0, 0};
  std::vector<std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<std::vector<std::size_t>> points_inside(const PointCloud& cloud,
                                                    std::span<const Box> boxes) {
  std::vector<std::vector<std::size_t>> result(boxes.size());
  const BoxesByPlace places(boxes);
  const std::size_t columns = cloud.columns(), count = cloud.size();
  for (std::size_t i = 0; i < count; ++i) {
    places.visit_holders(&cloud.values[i * columns],
                         [&](std::size_t box) { result[box].push_back(i); });
  }
  return result;
}

std::vector<std::int64_t> count_points(const PointCloud& cloud,
                                       std::span<const SceneObject> objects) {
  std::vector<Box> boxes;
  for (const SceneObject& object : objects) boxes.push_back(object.box);
  std::vector<std::int64_t> result;
  for (const auto& inside : points_inside(cloud, boxes)) result.push_back(std::ssize(inside));
  return result;
}

void remove_points_inside(PointCloud& cloud, std::span<const Box> boxes) {
  if (boxes.empty()) return;
  const BoxesByPlace places(boxes);
  const std::size_t columns = cloud.columns(), count = cloud.size();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float* point = &cloud.values[i * columns];
    bool inside = false;
    places.visit_holders(point, [&](std::size_t) { inside = true; });
    if (inside) continue;
    if (kept != i) std::copy(point, point + columns, &cloud.values[kept * columns]);
    ++kept;
  }
  cloud.values.resize(kept * columns);
}

}  // namespace arbox::training
