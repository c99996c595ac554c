#pragma once

#include "arbox/detectors/pv_rcnn/options.h"

namespace arbox::detectors::pv_rcnn::internal {

/// The map seen from above that leaves the 3-D backbone.
struct MapCells {
  /// Cells along x, y and z; not above zero where the range is too small.
  std::array<std::int64_t, 3> grid;
  /// Voxels that a cell spans along x and y.
  std::int64_t stride;
};

MapCells map_cells(const Options& options);

}  // namespace arbox::detectors::pv_rcnn::internal
