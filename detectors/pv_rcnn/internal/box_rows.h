#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <vector>

#include "arbox/geometry/box.h"

namespace arbox::detectors::pv_rcnn::internal {

/// Boxes that geometry accepts, with the rows that they come from.
struct UsableBoxes {
  std::vector<geometry::Box> boxes;
  std::vector<std::int64_t> rows;
  std::int64_t dropped = 0;
};

/// Of rows (N, 7): those whose numbers are finite and whose sizes are above zero.
UsableBoxes usable_boxes(const at::Tensor& boxes);

}  // namespace arbox::detectors::pv_rcnn::internal
