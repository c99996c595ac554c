#pragma once

#include <cstdint>

#include "arbox/base/cpu.h"

/// \file
/// The kernels under overlap.h, compiled once per instruction set (arbox_simd_sources).
///
/// Both intersection kernels put the origin in the centre of the smaller box, take the axes of the
/// larger one, and integrate over the boundary of the smaller box alone: with X, Y, Z the
/// coordinates clamped to the larger box, the volume is the surface integral of X dY dZ (in the
/// plane: the contour integral of X dY). Clamping is continuous, so coincident and nearly parallel
/// faces need no case and no tolerance, and the error stays at the rounding of the coordinates.

namespace arbox::geometry {

/// A valid box, prepared for the kernels.
struct OverlapBox {
  double center[3];
  double half[3];
  /// Row-major; the columns are the box's axes. For a level box: heading in [0] and [3].
  double rotation[9];
  double volume;
  /// The box's z axis is the frame's.
  bool level;
};

/// Vertical cylinders around boxes, one array a number: centres, radii, half heights.
struct OverlapBounds {
  const double* x;
  const double* y;
  const double* z;
  const double* radius;
  const double* reach;
};

struct OverlapKernels {
  /// Writes the indices in [0, count) of the bounds that meet `probe`'s (its element 0), in
  /// ascending order; returns how many. `found` holds count numbers.
  std::int64_t (*near)(const OverlapBounds& probe, const OverlapBounds& bounds, std::int64_t count,
                       std::int64_t* found);
  /// Intersection volumes of pairs of level boxes.
  void (*level)(const OverlapBox* const* first, const OverlapBox* const* second, std::int64_t count,
                double* volumes);
  /// Intersection volumes of pairs of any boxes.
  void (*free)(const OverlapBox* const* first, const OverlapBox* const* second, std::int64_t count,
               double* volumes);
};

/// The kernels of a level that this CPU has.
OverlapKernels overlap_kernels(SimdLevel level);

namespace scalar {
std::int64_t near_bounds(const OverlapBounds&, const OverlapBounds&, std::int64_t, std::int64_t*);
void level_intersections(const OverlapBox* const*, const OverlapBox* const*, std::int64_t, double*);
void free_intersections(const OverlapBox* const*, const OverlapBox* const*, std::int64_t, double*);
}  // namespace scalar
namespace avx2 {
std::int64_t near_bounds(const OverlapBounds&, const OverlapBounds&, std::int64_t, std::int64_t*);
void level_intersections(const OverlapBox* const*, const OverlapBox* const*, std::int64_t, double*);
void free_intersections(const OverlapBox* const*, const OverlapBox* const*, std::int64_t, double*);
}  // namespace avx2
namespace avx512 {
std::int64_t near_bounds(const OverlapBounds&, const OverlapBounds&, std::int64_t, std::int64_t*);
void level_intersections(const OverlapBox* const*, const OverlapBox* const*, std::int64_t, double*);
void free_intersections(const OverlapBox* const*, const OverlapBox* const*, std::int64_t, double*);
}  // namespace avx512

}  // namespace arbox::geometry
