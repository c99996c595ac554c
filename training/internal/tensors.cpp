#include "arbox/training/internal/tensors.h"

#include <ATen/ops/empty.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "arbox/base/error.h"

namespace arbox::training::internal {

std::string shape_text(const at::Tensor& tensor) {
  std::ostringstream text;
  text << tensor.sizes();
  return text.str();
}

at::Tensor double_rows(const at::Tensor& tensor) {
  return tensor.detach().to(at::kCPU, at::kDouble).contiguous();
}

at::Tensor to_tensor(const std::vector<std::int64_t>& values) {
  at::Tensor result = at::empty({static_cast<std::int64_t>(values.size())}, at::kLong);
  std::copy(values.begin(), values.end(), result.data_ptr<std::int64_t>());
  return result;
}

at::Tensor to_tensor(const std::vector<double>& values, at::ScalarType type) {
  at::Tensor result = at::empty({static_cast<std::int64_t>(values.size())}, at::kDouble);
  std::copy(values.begin(), values.end(), result.data_ptr<double>());
  return result.to(type);
}

at::Tensor to_rows(std::span<const SceneObject> objects, at::ScalarType type) {
  at::Tensor result = at::empty({static_cast<std::int64_t>(objects.size()), 7}, at::kDouble);
  double* row = result.data_ptr<double>();
  for (const SceneObject& object : objects) {
    for (int i = 0; i < 3; ++i) *row++ = object.box.center[i];
    for (int i = 0; i < 3; ++i) *row++ = object.box.size[i];
    *row++ = geometry::yaw(object.box);
  }
  return result.to(type);
}

std::vector<geometry::Box> to_boxes(const at::Tensor& rows) {
  const at::Tensor table = double_rows(rows);
  std::vector<geometry::Box> result;
  const double* row = table.data_ptr<double>();
  for (std::int64_t i = 0; i < table.size(0); ++i, row += 7) {
    const bool finite = std::all_of(row, row + 7, [](double one) { return std::isfinite(one); });
    if (!finite || row[3] <= 0 || row[4] <= 0 || row[5] <= 0) {
      throw NumericalError("boxes: row " + std::to_string(i) +
                           ": expected finite numbers and sizes above zero");
    }
    result.push_back(
        geometry::make_yaw_box({row[0], row[1], row[2]}, {row[3], row[4], row[5]}, row[6]));
  }
  return result;
}

}  // namespace arbox::training::internal
