#include "arbox/heads/quantizer.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/clamp.h>
#include <ATen/ops/round.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros_like.h>

#include <string>
#include <vector>

#include "arbox/base/error.h"

namespace arbox::heads {
namespace {

void require_columns(const at::Tensor& tensor, std::span<const Component> components,
                     const char* where) {
  if (tensor.dim() >= 1 && tensor.size(-1) == std::ssize(components)) return;
  throw InvalidArgument(std::string(where) + ": expected a last dimension of " +
                        std::to_string(components.size()) + " components, got " +
                        std::to_string(tensor.dim() ? tensor.size(-1) : 0));
}

}  // namespace

at::Tensor quantize(const at::Tensor& values, std::span<const Component> components,
                    CircularEnds ends) {
  require_columns(values, components, "quantize");
  std::vector<at::Tensor> bins;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const Component& component = components[i];
    at::Tensor bin = at::round((values.select(-1, static_cast<std::int64_t>(i)) - component.low) /
                               component.step());
    bin = at::clamp(bin, 0, component.bins - 1).to(at::kLong);
    if (component.circular && ends == CircularEnds::kMerged) {
      bin = bin.masked_fill(bin == component.bins - 1, 0);
    }
    bins.push_back(bin);
  }
  return at::stack(bins, -1);
}

at::Tensor dequantize(const at::Tensor& bins, std::span<const Component> components) {
  require_columns(bins, components, "dequantize");
  std::vector<at::Tensor> values;
  for (std::size_t i = 0; i < components.size(); ++i) {
    values.push_back(
        (bins.select(-1, static_cast<std::int64_t>(i)).to(at::kDouble) * components[i].step() +
         components[i].low)
            .to(at::kFloat));
  }
  return at::stack(values, -1);
}

at::Tensor overflows(const at::Tensor& values, std::span<const Component> components) {
  require_columns(values, components, "overflows");
  std::vector<at::Tensor> outside;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const Component& component = components[i];
    const at::Tensor value = values.select(-1, static_cast<std::int64_t>(i));
    const double margin = 0.5 * component.step();
    const at::Tensor out =
        (value < component.low - margin).logical_or(value > component.high + margin);
    outside.push_back(component.circular ? at::zeros_like(out) : out);
  }
  return at::stack(outside, -1);
}

}  // namespace arbox::heads
