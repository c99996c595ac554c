#include "arbox/sparse/point_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "arbox/base/cpu.h"
#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/sparse/internal/point_kernel.h"
#include "arbox/sparse/internal/radix_sort.h"

namespace arbox::sparse {
namespace {

std::int64_t require_points(std::span<const float> points, const char* where) {
  if (points.size() % 3 != 0) {
    throw InvalidArgument(std::string(where) + ": expected rows of x y z, got " +
                          std::to_string(points.size()) + " numbers");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::isfinite(points[i])) continue;
    throw InvalidArgument(std::string(where) + ": point " + std::to_string(i / 3) +
                          " is not finite; drop such points first");
  }
  return static_cast<std::int64_t>(points.size() / 3);
}

auto farthest_step() {
  switch (simd_level()) {
    case SimdLevel::kAvx512:
      return internal::avx512::farthest_step;
    case SimdLevel::kAvx2:
      return internal::avx2::farthest_step;
    case SimdLevel::kScalar:
      break;
  }
  return internal::scalar::farthest_step;
}

/// Points sorted by the cell that holds them, by index within a cell.
class CellGrid {
 public:
  CellGrid(std::span<const float> points, std::int64_t count, float radius) : points_(points) {
    for (int axis = 0; axis < 3; ++axis) {
      float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
      for (std::int64_t i = 0; i < count; ++i) {
        low = std::min(low, points[3 * i + axis]);
        high = std::max(high, points[3 * i + axis]);
      }
      low_[axis] = count > 0 ? low : 0;
      // At most 2^20 cells an axis: a tiny radius gets wider cells.
      width_[axis] = std::max<double>(radius, count > 0 ? (double{high} - low) / kMostCells : 0);
    }
    order_.resize(count);
    for (std::int64_t i = 0; i < count; ++i) {
      const auto c = cell(points.data() + 3 * i);
      order_[i] = {key(c[0], c[1], c[2]), static_cast<std::int32_t>(i)};
    }
    internal::radix_sort(order_, 63);
  }

  /// Calls visit(index) for every point in the 27 cells around `center`.
  template <class Visit>
  void around(const float* center, Visit visit) const {
    const auto [x, y, z] = cell(center);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        if (x + dx < 0 || y + dy < 0) continue;
        const std::uint64_t first = key(x + dx, y + dy, std::max<std::int64_t>(z - 1, 0));
        const std::uint64_t last = key(x + dx, y + dy, z + 1);
        if (z + 1 < 0) continue;
        auto item = std::lower_bound(
            order_.begin(), order_.end(), first,
            [](const internal::Keyed& a, std::uint64_t wanted) { return a.key < wanted; });
        for (; item != order_.end() && item->key <= last; ++item) visit(item->row);
      }
    }
  }

 private:
  static constexpr double kMostCells = 1 << 20;

  std::array<std::int64_t, 3> cell(const float* point) const {
    std::array<std::int64_t, 3> result;
    for (int axis = 0; axis < 3; ++axis) {
      const double index = std::floor((double{point[axis]} - low_[axis]) / width_[axis]);
      result[axis] = static_cast<std::int64_t>(std::clamp(index, -2.0, kMostCells + 2));
    }
    return result;
  }
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    return (static_cast<std::uint64_t>(x) << 42) | (static_cast<std::uint64_t>(y) << 21) |
           static_cast<std::uint64_t>(z);
  }

  std::span<const float> points_;
  std::array<double, 3> low_{}, width_{};
  std::vector<internal::Keyed> order_;
};

float squared_distance(const float* a, const float* b) {
  const float dx = a[0] - b[0], dy = a[1] - b[1], dz = a[2] - b[2];
  return dx * dx + dy * dy + dz * dz;
}

struct Hit {
  float distance;
  std::int32_t index;
};

void write_hits(std::vector<Hit>& hits, const BallQuery& query, std::int32_t* row) {
  const auto samples = static_cast<std::size_t>(query.samples);
  const auto before = [&](const Hit& a, const Hit& b) {
    if (query.rule == BallRule::kNearest && a.distance != b.distance) {
      return a.distance < b.distance;
    }
    return a.index < b.index;
  };
  const std::size_t taken = std::min(hits.size(), samples);
  std::partial_sort(hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(taken), hits.end(),
                    before);
  for (std::size_t i = 0; i < samples; ++i) {
    row[i] = hits.empty() ? -1 : hits[i < taken ? i : 0].index;
  }
}

}  // namespace

std::vector<std::int32_t> furthest_points(std::span<const float> points, std::int64_t count) {
  const std::int64_t size = require_points(points, "furthest_points");
  if (count < 0) throw InvalidArgument("furthest_points: count must not be negative");
  std::vector<std::int32_t> result;
  if (size == 0) return result;
  result.reserve(count);
  std::vector<float> columns(4 * size, std::numeric_limits<float>::max());
  for (std::int64_t i = 0; i < size; ++i) {
    for (int axis = 0; axis < 3; ++axis) columns[axis * size + i] = points[3 * i + axis];
  }
  const internal::FarthestState state{columns.data(), columns.data() + size,
                                      columns.data() + 2 * size, columns.data() + 3 * size, size};
  const auto step = farthest_step();
  std::int64_t chosen = 0;
  for (std::int64_t i = 0; i < std::min(count, size); ++i) {
    result.push_back(static_cast<std::int32_t>(chosen));
    chosen = step(state, chosen);
  }
  for (std::int64_t i = size; i < count; ++i) result.push_back(result[i - size]);
  return result;
}

std::vector<std::int32_t> ball_query(std::span<const float> points, std::span<const float> centres,
                                     const BallQuery& query, int threads) {
  const std::int64_t size = require_points(points, "ball_query");
  const std::int64_t count = require_points(centres, "ball_query (centres)");
  if (!(query.radius > 0) || !std::isfinite(query.radius) || query.samples < 1) {
    throw InvalidArgument("ball_query: expected a radius above 0 and at least 1 sample, got " +
                          std::to_string(query.radius) + " and " + std::to_string(query.samples));
  }
  std::vector<std::int32_t> result(count * query.samples, -1);
  const CellGrid grid(points, size, query.radius);
  const float squared_radius = query.radius * query.radius;
  parallel_for(count, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Hit> hits;
    for (std::int64_t c = begin; c < end; ++c) {
      hits.clear();
      const float* center = centres.data() + 3 * c;
      grid.around(center, [&](std::int32_t index) {
        const float distance = squared_distance(points.data() + 3 * std::int64_t{index}, center);
        if (distance < squared_radius) hits.push_back({distance, index});
      });
      write_hits(hits, query, result.data() + c * query.samples);
    }
  });
  return result;
}

std::vector<std::int32_t> box_of_points(std::span<const float> points,
                                        std::span<const double> boxes, double margin, int threads) {
  const auto size = static_cast<std::int64_t>(points.size() / 3);
  if (points.size() % 3 != 0 || boxes.size() % 10 != 0) {
    throw InvalidArgument("box_of_points: expected points of 3 and boxes of 10 numbers");
  }
  const auto count = static_cast<std::int64_t>(boxes.size() / 10);
  std::vector<std::array<double, 9>> axes(count);
  for (std::int64_t b = 0; b < count; ++b) {
    const double* box = boxes.data() + 10 * b;
    const double norm =
        std::sqrt(box[6] * box[6] + box[7] * box[7] + box[8] * box[8] + box[9] * box[9]);
    const double w = box[6] / norm, x = box[7] / norm, y = box[8] / norm, z = box[9] / norm;
    // Columns of the rotation matrix: the axes of the box.
    axes[b] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
               2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
               2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
  }
  std::vector<std::int32_t> result(size, -1);
  parallel_for(size, 1024, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const float* p = points.data() + 3 * i;
      for (std::int64_t b = 0; b < count && result[i] < 0; ++b) {
        const double* box = boxes.data() + 10 * b;
        const double dx = p[0] - box[0], dy = p[1] - box[1], dz = p[2] - box[2];
        bool inside = true;
        for (int axis = 0; axis < 3 && inside; ++axis) {
          const double* a = axes[b].data() + 3 * axis;
          inside = std::abs(dx * a[0] + dy * a[1] + dz * a[2]) <= box[3 + axis] / 2 + margin;
        }
        if (inside) result[i] = static_cast<std::int32_t>(b);
      }
    }
  });
  return result;
}

}  // namespace arbox::sparse
