#pragma once

#include "arbox/sparse/kernel_geometry.h"
#include "arbox/sparse/sparse_tensor.h"

namespace arbox::sparse {

/// Largest feature over the inputs that exist in each output's window, per channel. Outputs and
/// windows as in convolution(); kernel 2, stride 2 on an unbounded tensor takes the children of
/// each cell. A grid cell whose window holds no input does not occur. Ties go to the earliest
/// kernel element, and so does the gradient. NaN wins. CPU only: throws NotAvailable elsewhere;
/// float32 and float64.
SparseTensor max_pool(const SparseTensor& input, const Kernel& kernel);

/// Mean over the inputs that exist in each output's window. As max_pool otherwise.
SparseTensor average_pool(const SparseTensor& input, const Kernel& kernel);

}  // namespace arbox::sparse
