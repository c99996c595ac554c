#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "arbox/sparse/coordinates.h"

namespace arbox::sparse {

/// Which input voxel each kernel element reads: input = output * scale + origin + offsets[k].
///
/// MinkowskiEngine's convention (unbounded coordinates in units of the finest voxel): scale 1,
/// origin 0, offsets multiplied by the input's stride and the dilation. spconv's convention
/// (coordinates of a bounded grid): scale = stride, origin = -padding, offsets = index * dilation.
struct KernelGeometry {
  std::vector<std::array<std::int32_t, 3>> offsets;
  std::array<std::int32_t, 3> scale{1, 1, 1};
  std::array<std::int32_t, 3> origin{0, 0, 0};
};

/// The pairs of voxels that meet in a convolution, grouped by kernel element.
///
/// Positions count in sorted order (SortedCoordinates); within one kernel element both the input
/// and the output positions rise, so that either side can be cut into tiles.
struct KernelMap {
  std::vector<std::int32_t> inputs, outputs;
  /// Pairs of kernel element k are [starts[k], starts[k + 1]).
  std::vector<std::int64_t> starts;

  std::int64_t elements() const { return static_cast<std::int64_t>(starts.size()) - 1; }
  std::int64_t pairs() const { return static_cast<std::int64_t>(inputs.size()); }
};

/// Finds the pairs by merging the two sorted lists once for every column of offsets that differ in
/// z alone; a kernel that is symmetric over one coordinate set is searched by half.
///
/// O((inputs + outputs) * columns). Coordinates must be unique. threads = 0 means
/// default_threads(); the result does not depend on it. No input or no output gives no pairs.
KernelMap build_kernel_map(const SortedCoordinates& inputs, const SortedCoordinates& outputs,
                           const KernelGeometry& geometry, int threads = 0);

}  // namespace arbox::sparse
