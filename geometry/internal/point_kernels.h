#pragma once

#include <cstddef>

#include "arbox/base/cpu.h"

namespace arbox::geometry::internal {

/// Kernels take points as three arrays whose length is a multiple of this.
inline constexpr std::size_t kPointPadding = 32;

/// A weighted box as the kernels read it: a point p is inside if |axes p - offset| <= half in each
/// component. `axes` is row-major, one row an own axis.
struct KernelBox {
  double axes[9];
  double offset[3];
  double half[3];
  double weight;
};

struct PointKernels {
  /// weight[i] = sum of the weights of the boxes that hold point i, added in the boxes' order.
  void (*occupancy)(const double* x, const double* y, const double* z, std::size_t count,
                    const KernelBox* boxes, std::size_t box_count, double* weight);
  /// Widens extents[6 r ..] (lows, then highs along the three rows of rotation r) to the points.
  void (*extents)(const double* x, const double* y, const double* z, std::size_t count,
                  const double* rotations, std::size_t rotation_count, double* extents);
};

/// The kernels of one instruction set; the CPU must have it.
const PointKernels& point_kernels(SimdLevel level);

}  // namespace arbox::geometry::internal
