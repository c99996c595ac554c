#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <string>

namespace torch::nn {
class Module;
}

namespace arbox::heads {

using NamedTensors = std::map<std::string, at::Tensor>;

/// Copies of a module's parameters and buffers by name, on the CPU and contiguous.
NamedTensors parameters_of(const torch::nn::Module& module);

/// Copies tensors into a module's parameters and buffers, in its own dtype. Nothing is copied
/// unless all names and shapes fit: FormatError that begins with `source` lists every missing name,
/// every unknown one, every shape that differs (with both), whole numbers for fractions and the
/// other way round, and every tensor with a non-finite number.
void load_parameters(torch::nn::Module& module, const NamedTensors& tensors,
                     const std::string& source);

}  // namespace arbox::heads
