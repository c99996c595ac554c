#include "arbox/heads/internal/finite_boxes.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/isfinite.h>

#include "arbox/heads/box_tensor.h"

namespace arbox::heads::internal {

FiniteBoxes finite_boxes(const at::Tensor& boxes) {
  require_boxes(boxes, "finite_boxes");
  const at::Tensor rotation = boxes.slice(1, 6, 10);
  const at::Tensor usable = at::isfinite(boxes)
                                .all(1)
                                .logical_and((boxes.slice(1, 3, 6) > 0).all(1))
                                .logical_and((rotation * rotation).sum(1) > 1e-6);
  const at::Tensor index = usable.nonzero().select(1, 0).contiguous();
  const std::int64_t* row = index.data_ptr<std::int64_t>();
  return {to_boxes(boxes.index_select(0, index)), {row, row + index.numel()}};
}

}  // namespace arbox::heads::internal
