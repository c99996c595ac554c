#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <vector>

#include "arbox/geometry/box.h"

namespace arbox::heads::internal {

/// The usable rows of a (N, 10) tensor of boxes: finite, with sizes above zero.
struct FiniteBoxes {
  std::vector<geometry::Box> boxes;
  std::vector<std::int64_t> rows;  ///< Of each box.
};
FiniteBoxes finite_boxes(const at::Tensor& boxes);

}  // namespace arbox::heads::internal
