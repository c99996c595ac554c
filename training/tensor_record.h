#pragma once

#include <ATen/core/Tensor.h>

#include <string>

#include "arbox/io/model_archive.h"

namespace arbox::training {

/// The numbers of a tensor, bit by bit. Throws InvalidArgument for a type that files do not have
/// (bfloat16, complex, quantised).
io::ModelRecord to_record(const at::Tensor& tensor);

/// A tensor with its own memory, on the CPU. Throws FormatError for uint16, uint32 and uint64,
/// which tensors do not have.
at::Tensor to_tensor(const io::ModelRecord& record);

}  // namespace arbox::training
