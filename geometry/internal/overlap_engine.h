#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arbox/base/cpu.h"
#include "arbox/geometry/internal/overlap_kernels.h"
#include "arbox/geometry/overlap.h"

/// \file
/// What stands between overlap.h and its kernels. The functions of overlap.h call the *_at
/// functions with simd_level(); tests and benchmarks choose the level.

namespace arbox::geometry::internal {

/// The vertical cylinder that encloses a box.
struct Bound {
  double x, y, z, radius, reach;
};

/// `box` as the kernels see it in `space`: bird's eye gives every box the height 1 at z = 0,
/// axis-aligned drops the rotation. The box is valid.
OverlapBox prepared(const Box& box, OverlapSpace space);

Bound bound(const OverlapBox& box);

/// Throws InvalidArgument, naming `where` and the row, for what overlap.h says is refused.
void require_measurable(std::span<const Box> boxes, OverlapSpace space, std::string_view where);

/// Prepared boxes and their bounds in arrays.
class OverlapBoxes {
 public:
  OverlapBoxes(std::span<const Box> boxes, OverlapSpace space);

  std::int64_t size() const { return static_cast<std::int64_t>(boxes_.size()); }
  const OverlapBox& operator[](std::int64_t i) const { return boxes_[i]; }
  /// Bounds from box i on.
  OverlapBounds bounds(std::int64_t i) const {
    return {x_.data() + i, y_.data() + i, z_.data() + i, radius_.data() + i, reach_.data() + i};
  }

 private:
  std::vector<OverlapBox> boxes_;
  std::vector<double> x_, y_, z_, radius_, reach_;
};

/// Collects pairs and hands them to the kernel that fits, many at a time. A pair's result does not
/// depend on what else is in the batch.
class PairBatch {
 public:
  PairBatch(const OverlapKernels& kernels, Overlap measure)
      : kernels_(kernels), measure_(measure) {}

  /// `*target` gets the overlap at the next flush() or before; the boxes must live until then.
  void add(const OverlapBox& first, const OverlapBox& second, double* target);
  void flush();

 private:
  static constexpr int kCapacity = 64;
  struct Pairs {
    std::array<const OverlapBox*, kCapacity> first, second;
    std::array<double*, kCapacity> target;
    int count = 0;
  };
  void flush(Pairs& pairs, decltype(OverlapKernels::level) kernel) const;

  OverlapKernels kernels_;
  Overlap measure_;
  Pairs level_, free_;
};

double overlap_at(SimdLevel level, const Box& first, const Box& second,
                  const OverlapOptions& options);

/// `result` is row-major, first.size() * second.size() numbers.
void overlap_matrix_at(SimdLevel level, std::span<const Box> first, std::span<const Box> second,
                       const OverlapOptions& options, double* result);

void overlap_pairs_at(SimdLevel level, std::span<const Box> first, std::span<const Box> second,
                      const OverlapOptions& options, double* result);

}  // namespace arbox::geometry::internal
