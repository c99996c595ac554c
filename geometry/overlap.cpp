#include "arbox/geometry/overlap.h"

#include <algorithm>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/geometry/internal/overlap_engine.h"

namespace arbox::geometry {
namespace internal {

double overlap_at(SimdLevel level, const Box& first, const Box& second,
                  const OverlapOptions& options) {
  require_measurable({&first, 1}, options.space, "overlap: first");
  require_measurable({&second, 1}, options.space, "overlap: second");
  const OverlapKernels kernels = overlap_kernels(level);
  const OverlapBox a = prepared(first, options.space), b = prepared(second, options.space);
  const Bound near_a = bound(a), near_b = bound(b);
  const auto columns = [](const Bound& c) {
    return OverlapBounds{&c.x, &c.y, &c.z, &c.radius, &c.reach};
  };
  double result = 0.0;
  std::int64_t found;
  if (kernels.near(columns(near_a), columns(near_b), 1, &found) == 0) return result;
  PairBatch batch(kernels, options.measure);
  batch.add(a, b, &result);
  batch.flush();
  return result;
}

void overlap_matrix_at(SimdLevel level, std::span<const Box> first, std::span<const Box> second,
                       const OverlapOptions& options, double* result) {
  require_measurable(first, options.space, "overlap_matrix: first");
  require_measurable(second, options.space, "overlap_matrix: second");
  const OverlapKernels kernels = overlap_kernels(level);
  const OverlapBoxes rows(first, options.space), columns(second, options.space);
  if (rows.size() == 0 || columns.size() == 0) return;
  const std::int64_t grain = std::max<std::int64_t>(1, 8192 / columns.size());
  parallel_for(rows.size(), grain, options.threads, [&](std::int64_t begin, std::int64_t end) {
    PairBatch batch(kernels, options.measure);
    std::vector<std::int64_t> found(columns.size());
    for (std::int64_t row = begin; row < end; ++row) {
      double* overlaps = result + row * columns.size();
      std::fill_n(overlaps, columns.size(), 0.0);
      const std::int64_t count =
          kernels.near(rows.bounds(row), columns.bounds(0), columns.size(), found.data());
      for (std::int64_t i = 0; i < count; ++i) {
        batch.add(rows[row], columns[found[i]], overlaps + found[i]);
      }
    }
    batch.flush();
  });
}

void overlap_pairs_at(SimdLevel level, std::span<const Box> first, std::span<const Box> second,
                      const OverlapOptions& options, double* result) {
  if (first.size() != second.size()) {
    throw InvalidArgument("overlap_pairs: expected as many second boxes as first, got " +
                          std::to_string(first.size()) + " first and " +
                          std::to_string(second.size()) + " second");
  }
  require_measurable(first, options.space, "overlap_pairs: first");
  require_measurable(second, options.space, "overlap_pairs: second");
  const OverlapKernels kernels = overlap_kernels(level);
  const OverlapBoxes a(first, options.space), b(second, options.space);
  parallel_for(a.size(), 256, options.threads, [&](std::int64_t begin, std::int64_t end) {
    PairBatch batch(kernels, options.measure);
    std::int64_t found;
    for (std::int64_t i = begin; i < end; ++i) {
      result[i] = 0.0;
      if (kernels.near(a.bounds(i), b.bounds(i), 1, &found)) batch.add(a[i], b[i], result + i);
    }
    batch.flush();
  });
}

}  // namespace internal

double overlap(const Box& first, const Box& second, const OverlapOptions& options) {
  return internal::overlap_at(simd_level(), first, second, options);
}

Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> overlap_matrix(
    std::span<const Box> first, std::span<const Box> second, const OverlapOptions& options) {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> result(first.size(),
                                                                                second.size());
  internal::overlap_matrix_at(simd_level(), first, second, options, result.data());
  return result;
}

Eigen::VectorXd overlap_pairs(std::span<const Box> first, std::span<const Box> second,
                              const OverlapOptions& options) {
  Eigen::VectorXd result(first.size());
  internal::overlap_pairs_at(simd_level(), first, second, options, result.data());
  return result;
}

}  // namespace arbox::geometry
