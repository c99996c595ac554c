#include "arbox/heads/box_tensor.h"

#include <ATen/ops/empty.h>

#include <sstream>
#include <string>

#include "arbox/base/error.h"

namespace arbox::heads {

at::Tensor to_tensor(std::span<const geometry::Box> boxes, at::ScalarType type) {
  at::Tensor result =
      at::empty({static_cast<std::int64_t>(boxes.size()), kBoxColumns}, at::kDouble);
  double* row = result.data_ptr<double>();
  for (const geometry::Box& box : boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      row[axis] = box.center[axis];
      row[3 + axis] = box.size[axis];
    }
    row[6] = box.rotation.w();
    row[7] = box.rotation.x();
    row[8] = box.rotation.y();
    row[9] = box.rotation.z();
    row += kBoxColumns;
  }
  return result.to(type);
}

std::vector<geometry::Box> to_boxes(const at::Tensor& tensor) {
  require_boxes(tensor, "to_boxes");
  if (tensor.dim() != 2) {
    throw InvalidArgument("to_boxes: expected shape (N, 10), got " + std::to_string(tensor.dim()) +
                          " dimensions");
  }
  const at::Tensor rows = tensor.detach().to(at::kCPU, at::kDouble).contiguous();
  const double* row = rows.data_ptr<double>();
  std::vector<geometry::Box> boxes(static_cast<std::size_t>(rows.size(0)));
  for (std::size_t i = 0; i < boxes.size(); ++i, row += kBoxColumns) {
    geometry::Box& box = boxes[i];
    box.center = {row[0], row[1], row[2]};
    box.size = {row[3], row[4], row[5]};
    box.rotation = {row[6], row[7], row[8], row[9]};
    const bool finite = box.center.allFinite() && box.size.allFinite() &&
                        box.rotation.coeffs().allFinite() && box.rotation.norm() > 1e-6;
    if (!finite || (box.size.array() <= 0.0).any()) {
      throw NumericalError("to_boxes: row " + std::to_string(i) +
                           " holds a non-finite number or a size that is not above zero");
    }
    box.rotation.normalize();
  }
  return boxes;
}

void require_boxes(const at::Tensor& tensor, const char* where) {
  if (tensor.dim() >= 1 && tensor.size(-1) == kBoxColumns) return;
  std::ostringstream text;
  text << where << ": expected boxes of shape (..., 10), got " << tensor.sizes();
  throw InvalidArgument(text.str());
}

}  // namespace arbox::heads
