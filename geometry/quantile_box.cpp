#include "arbox/geometry/quantile_box.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/geometry/internal/enclosing.h"
#include "arbox/geometry/internal/sample_set.h"

namespace arbox::geometry {
namespace {

using namespace internal;

// Boxes thinner than this part of the largest sample have no volume.
constexpr double kFlat = 1e-9;

void require_quantiles(std::span<const double> qs) {
  for (std::size_t i = 0; i < qs.size(); ++i) {
    if (qs[i] >= 0.0 && qs[i] <= 1.0) continue;
    throw InvalidArgument("quantile_boxes: q in row " + std::to_string(i) +
                          " must be between 0 and 1, got " + std::to_string(qs[i]));
  }
}

PointSet gather(const PointSet& points, std::span<const std::size_t> indices) {
  PointSet result;
  result.reserve(indices.size());
  for (const std::size_t i : indices) result.push_back(points.x[i], points.y[i], points.z[i]);
  result.pad();
  return result;
}

/// The smallest box around a growing set of points of one object.
class GrowingBox {
 public:
  GrowingBox(const SampleSet& set, const PointSet& points, bool refine)
      : set_(set), points_(points), refine_(refine), extents_(set.rotations.size()) {
    std::fill(extents_.begin(), extents_.end(), empty_extents());
    rows_.reserve(set.rotations.size());
    for (const Quaternion& rotation : set.rotations) rows_.push_back(rows_of(rotation));
    double largest = 0.0;
    for (const Box& box : set.boxes) largest = std::max(largest, box.size.maxCoeff());
    least_size_ = kFlat * largest;
  }

  void add(std::span<const std::size_t> indices) {
    if (indices.empty()) return;
    widen(gather(points_, indices), rows_, extents_);
    if (refine_) members_.insert(members_.end(), indices.begin(), indices.end());
  }

  /// Empty while the points lie in a plane.
  std::optional<Box> box() const {
    const std::size_t best = least_volume(extents_);
    // No points: the sizes are minus infinity.
    if (!(size_of(extents_[best]).minCoeff() > least_size_)) return std::nullopt;
    const Box sampled = box_of(extents_[best], set_.rotations[best], Eigen::Vector3d::Zero());
    Box result = sampled;
    if (refine_) {
      const PointSet members = gather(points_, members_);
      result =
          set_.yaw_only ? smallest_about(members, sampled.rotation) : descend(members, sampled);
      if (!(volume(result) < volume(sampled))) result = sampled;
    }
    result.center += set_.origin;
    return result;
  }

 private:
  const SampleSet& set_;
  const PointSet& points_;
  bool refine_;
  double least_size_;
  std::vector<RotationRows> rows_;
  std::vector<Extents> extents_;
  std::vector<std::size_t> members_;
};

/// The quantile boxes of one object, found from the highest q downwards.
class ObjectQuantiles {
 public:
  ObjectQuantiles(const BoxSamples& samples, const QuantileOptions& options)
      : set_(make_sample_set(samples)),
        points_(make_points(samples, set_, options)),
        occupancy_(occupancies(set_, points_)),
        refine_(options.refine) {}

  std::vector<QuantileBox> boxes(std::span<const double> qs) const {
    std::vector<std::size_t> order(qs.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return qs[a] > qs[b]; });
    const auto levels = points_by_level(qs, order);
    std::vector<QuantileBox> result(qs.size());
    std::optional<Box> fallback;
    GrowingBox growing(set_, points_, refine_);
    std::optional<Box> latest;
    for (std::size_t level = 0; level < order.size(); ++level) {
      growing.add(levels[level]);
      if (level == 0 || !levels[level].empty()) latest = growing.box();
      if (!latest && !fallback) fallback = fallback_box();
      result[order[level]] = {.q = qs[order[level]],
                              .box = latest ? *latest : *fallback,
                              .fallback = !latest.has_value()};
    }
    return result;
  }

 private:
  /// For each q, highest first, the points above it that are not above the one before.
  std::vector<std::vector<std::size_t>> points_by_level(std::span<const double> qs,
                                                        std::span<const std::size_t> order) const {
    std::vector<std::vector<std::size_t>> levels(order.size());
    if (order.empty()) return levels;
    const double lowest = qs[order.back()];
    for (std::size_t i = 0; i < occupancy_.size(); ++i) {
      if (!(occupancy_[i] > lowest)) continue;
      std::size_t level = 0;
      while (!(occupancy_[i] > qs[order[level]])) ++level;
      levels[level].push_back(i);
    }
    return levels;
  }

  /// The box of the most occupied points, down to the first occupancy at which they have a volume.
  Box fallback_box() const {
    std::vector<std::size_t> order(occupancy_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return occupancy_[a] > occupancy_[b]; });
    GrowingBox growing(set_, points_, refine_);
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
      while (end < order.size() && occupancy_[order[end]] == occupancy_[order[begin]]) ++end;
      growing.add(std::span(order).subspan(begin, end - begin));
      if (const auto box = growing.box()) return *box;
    }
    const auto heaviest = std::max_element(set_.weights.begin(), set_.weights.end());
    return set_.boxes[heaviest - set_.weights.begin()];
  }

  SampleSet set_;
  PointSet points_;
  std::vector<double> occupancy_;
  bool refine_;
};

std::vector<Eigen::Vector3d> to_vectors(const PointSet& points, const Eigen::Vector3d& origin) {
  std::vector<Eigen::Vector3d> result;
  result.reserve(points.count);
  for (std::size_t i = 0; i < points.count; ++i) result.push_back(origin + points[i]);
  return result;
}

}  // namespace

double occupancy(const BoxSamples& samples, const Eigen::Vector3d& point) {
  require_valid(samples, "occupancy");
  if (!point.allFinite()) throw InvalidArgument("occupancy: the point is not finite");
  const SampleSet set = make_sample_set(samples);
  const Eigen::Vector3d local = point - set.origin;
  PointSet points;
  points.push_back(local.x(), local.y(), local.z());
  points.pad();
  return occupancies(set, points).front();
}

double occupancy(std::span<const Box> samples, const Eigen::Vector3d& point) {
  return occupancy(BoxSamples{.boxes = samples}, point);
}

std::vector<Eigen::Vector3d> occupancy_points(const BoxSamples& samples,
                                              const QuantileOptions& options) {
  require_valid(samples, "occupancy_points");
  require_valid(options);
  const SampleSet set = make_sample_set(samples);
  return to_vectors(make_points(samples, set, options), set.origin);
}

std::vector<Eigen::Vector3d> occupancy_quantile(const BoxSamples& samples, double q,
                                                const QuantileOptions& options) {
  require_valid(samples, "occupancy_quantile");
  require_valid(options);
  require_quantiles({&q, 1});
  const SampleSet set = make_sample_set(samples);
  const PointSet points = make_points(samples, set, options);
  const std::vector<double> values = occupancies(set, points);
  std::vector<Eigen::Vector3d> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] > q) result.push_back(set.origin + points[i]);
  }
  return result;
}

std::vector<std::vector<QuantileBox>> quantile_boxes(std::span<const BoxSamples> objects,
                                                     std::span<const double> qs,
                                                     const QuantileOptions& options) {
  require_valid(options);
  require_quantiles(qs);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    require_valid(objects[i], objects.size() == 1 ? "quantile_boxes"
                                                  : "quantile_boxes: object " + std::to_string(i));
  }
  std::vector<std::vector<QuantileBox>> result(objects.size());
  const auto count = static_cast<std::int64_t>(objects.size());
  parallel_for(count, 1, options.threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      result[i] = ObjectQuantiles(objects[i], options).boxes(qs);
    }
  });
  return result;
}

std::vector<QuantileBox> quantile_boxes(const BoxSamples& samples, std::span<const double> qs,
                                        const QuantileOptions& options) {
  return quantile_boxes(std::span(&samples, 1), qs, options).front();
}

std::vector<QuantileBox> quantile_boxes(std::span<const Box> samples, std::span<const double> qs,
                                        const QuantileOptions& options) {
  return quantile_boxes(BoxSamples{.boxes = samples}, qs, options);
}

}  // namespace arbox::geometry
