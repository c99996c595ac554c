#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "arbox/training/scene.h"

namespace arbox::training::internal {

std::string shape_text(const at::Tensor& tensor);

/// The same numbers as contiguous doubles on the CPU, without gradient.
at::Tensor double_rows(const at::Tensor& tensor);

/// Copies.
at::Tensor to_tensor(const std::vector<std::int64_t>& values);
at::Tensor to_tensor(const std::vector<double>& values, at::ScalarType type);

/// (objects.size(), 7): x y z l w h yaw.
at::Tensor to_rows(std::span<const SceneObject> objects, at::ScalarType type = at::kFloat);

/// Rows x y z l w h yaw as boxes. Throws NumericalError, naming the row, for numbers that are not
/// finite and sizes that are not above zero.
std::vector<geometry::Box> to_boxes(const at::Tensor& rows);

}  // namespace arbox::training::internal
