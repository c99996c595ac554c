#pragma once

#include <ATen/core/Tensor.h>

#include "arbox/sparse/coordinate_manager.h"

// Sparse convolution by LibTorch's own operators: any device, float32 and float64.

namespace arbox::sparse::internal {

at::Tensor plain_convolve(const Connection& connection, const at::Tensor& features,
                          const at::Tensor& weight);
at::Tensor plain_input_gradient(const Connection& connection, const at::Tensor& gradient,
                                const at::Tensor& weight);
at::Tensor plain_weight_gradient(const Connection& connection, const at::Tensor& features,
                                 const at::Tensor& gradient);

}  // namespace arbox::sparse::internal
