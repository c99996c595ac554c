#include "arbox/heads/parameters.h"

#include <ATen/core/ivalue.h>  // before nn headers: clang cannot parse them otherwise
#include <ATen/ops/isfinite.h>
#include <torch/nn/module.h>

#include <sstream>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/names.h"

namespace arbox::heads {
namespace {

/// The module's own tensors, not copies.
NamedTensors handles(const torch::nn::Module& module) {
  NamedTensors result;
  for (const auto& one : module.named_parameters()) result[one.key()] = one.value();
  for (const auto& one : module.named_buffers()) result[one.key()] = one.value();
  return result;
}

std::string shape_text(const at::Tensor& tensor) {
  std::ostringstream text;
  text << tensor.sizes();
  return text.str();
}

}  // namespace

NamedTensors parameters_of(const torch::nn::Module& module) {
  NamedTensors result;
  for (const auto& [name, tensor] : handles(module)) {
    result[name] = tensor.detach().to(at::kCPU).contiguous().clone();
  }
  return result;
}

void load_parameters(torch::nn::Module& module, const NamedTensors& tensors,
                     const std::string& source) {
  const NamedTensors own = handles(module);
  std::vector<std::string> violations;
  for (const auto& [name, tensor] : own) {
    const auto found = tensors.find(name);
    if (found == tensors.end()) {
      violations.push_back("'" + name + "' is missing");
    } else if (found->second.sizes() != tensor.sizes()) {
      violations.push_back("'" + name + "' has shape " + shape_text(found->second) + ", expected " +
                           shape_text(tensor));
    } else if (found->second.is_floating_point() != tensor.is_floating_point()) {
      violations.push_back("'" + name + "' has type " + c10::toString(found->second.scalar_type()) +
                           ", expected " + c10::toString(tensor.scalar_type()));
    } else if (!at::isfinite(found->second).all().item<bool>()) {
      violations.push_back("'" + name + "' holds a non-finite number");
    }
  }
  for (const auto& [name, tensor] : tensors) {
    if (!own.contains(name)) violations.push_back("'" + name + "' is unknown");
  }
  if (!violations.empty()) throw FormatError(source + ": " + join(violations, "; "));
  for (const auto& [name, tensor] : own) tensor.detach().copy_(tensors.at(name));
}

}  // namespace arbox::heads
