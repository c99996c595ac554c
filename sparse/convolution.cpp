#include "arbox/sparse/convolution.h"

#include <ATen/ops/empty.h>
#include <torch/csrc/autograd/custom_function.h>

#include <sstream>
#include <string>

#include "arbox/base/error.h"
#include "arbox/sparse/convolution_map.h"
#include "arbox/sparse/internal/held_connection.h"
#include "arbox/sparse/internal/plain_convolution.h"

namespace arbox::sparse {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

MapRows rows_of(const Connection& connection) {
  return {connection.inputs->sorted().rows, connection.outputs->sorted().rows};
}

bool runs_own_kernels(const at::Tensor& features) {
  return features.is_cpu() && features.scalar_type() == at::kFloat;
}

std::span<const float> numbers(const at::Tensor& tensor) {
  if (!tensor.defined()) return {};
  return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

at::Tensor own_forward(const Connection& connection, const at::Tensor& features,
                       const at::Tensor& weight, const FusedEpilogue& epilogue) {
  const at::Tensor input = features.contiguous(), kernel = weight.contiguous();
  const at::Tensor residual =
      epilogue.residual.defined() ? epilogue.residual.contiguous() : at::Tensor();
  at::Tensor result = at::empty({connection.outputs->size(), weight.size(2)}, features.options());
  convolve(*connection.map, rows_of(connection), input.data_ptr<float>(), kernel.data_ptr<float>(),
           static_cast<std::int32_t>(weight.size(1)), static_cast<std::int32_t>(weight.size(2)),
           result.data_ptr<float>(),
           {.scale = numbers(epilogue.scale),
            .shift = numbers(epilogue.shift),
            .residual = residual.defined() ? residual.data_ptr<float>() : nullptr,
            .relu = epilogue.relu});
  return result;
}

at::Tensor own_input_gradient(const Connection& connection, const at::Tensor& gradient,
                              const at::Tensor& weight) {
  const at::Tensor kernel = weight.contiguous();
  at::Tensor result = at::empty({connection.inputs->size(), weight.size(1)}, gradient.options());
  convolve_input_gradient(*connection.map, rows_of(connection), gradient.data_ptr<float>(),
                          kernel.data_ptr<float>(), static_cast<std::int32_t>(weight.size(1)),
                          static_cast<std::int32_t>(weight.size(2)), result.data_ptr<float>());
  return result;
}

at::Tensor own_weight_gradient(const Connection& connection, const at::Tensor& features,
                               const at::Tensor& gradient) {
  const at::Tensor input = features.contiguous();
  at::Tensor result = at::empty({connection.map->elements(), features.size(1), gradient.size(1)},
                                features.options());
  convolve_weight_gradient(*connection.map, rows_of(connection), input.data_ptr<float>(),
                           gradient.data_ptr<float>(), static_cast<std::int32_t>(features.size(1)),
                           static_cast<std::int32_t>(gradient.size(1)), result.data_ptr<float>());
  return result;
}

class SparseConvolution : public torch::autograd::Function<SparseConvolution> {
 public:
  /// bias: empty for none (autograd takes no undefined tensor).
  static at::Tensor forward(AutogradContext* context, const at::Tensor& features,
                            const at::Tensor& weight, const at::Tensor& bias,
                            const Connection& connection) {
    const bool biased = bias.numel() > 0;
    context->save_for_backward({features, weight});
    context->saved_data["bias"] = biased;
    context->saved_data["connection"] = internal::hold(connection);
    if (runs_own_kernels(features)) {
      return own_forward(connection, features, weight, {.shift = biased ? bias : at::Tensor()});
    }
    at::Tensor result = internal::plain_convolve(connection, features, weight);
    return biased ? result.add_(bias) : result;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &features = saved[0], &weight = saved[1];
    const at::Tensor gradient = gradients[0].contiguous();
    const Connection connection = internal::held(context->saved_data["connection"]);
    const bool own = runs_own_kernels(features);
    at::Tensor to_features, to_weight, to_bias;
    if (context->needs_input_grad(0)) {
      to_features = own ? own_input_gradient(connection, gradient, weight)
                        : internal::plain_input_gradient(connection, gradient, weight);
    }
    if (context->needs_input_grad(1)) {
      to_weight = own ? own_weight_gradient(connection, features, gradient)
                      : internal::plain_weight_gradient(connection, features, gradient);
    }
    if (context->saved_data["bias"].toBool()) to_bias = gradient.sum(0);
    return {to_features, to_weight, to_bias, at::Tensor()};
  }
};

void refuse(const char* what, const at::Tensor& tensor) {
  std::ostringstream text;
  text << "sparse convolution: " << what << ", got " << tensor.scalar_type() << " "
       << tensor.sizes() << " on " << tensor.device();
  throw InvalidArgument(text.str());
}

at::Tensor checked_weight(const Connection& connection, const at::Tensor& features,
                          const at::Tensor& weight) {
  const bool known =
      features.dim() == 2 && features.size(0) == connection.inputs->size() &&
      (features.scalar_type() == at::kFloat || features.scalar_type() == at::kDouble);
  if (!known) refuse("expected float32 or float64 features, one row a voxel", features);
  const at::Tensor kernel = weight.dim() == 2 ? weight.unsqueeze(0) : weight;
  if (kernel.dim() != 3 || kernel.size(0) != connection.map->elements() ||
      kernel.size(1) != features.size(1) || kernel.scalar_type() != features.scalar_type() ||
      kernel.device() != features.device()) {
    refuse(("expected weights (" + std::to_string(connection.map->elements()) + ", " +
            std::to_string(features.size(1)) + ", out) of the features' type and device")
               .c_str(),
           weight);
  }
  return kernel;
}

at::Tensor checked_vector(const at::Tensor& vector, const at::Tensor& kernel, const char* what) {
  if (!vector.defined()) return vector;
  if (vector.numel() != kernel.size(2) || vector.scalar_type() != kernel.scalar_type() ||
      vector.device() != kernel.device()) {
    refuse(what, vector);
  }
  return vector.reshape({-1}).contiguous();
}

}  // namespace

at::Tensor convolve(const Connection& connection, const at::Tensor& features,
                    const at::Tensor& weight, const at::Tensor& bias) {
  const at::Tensor kernel = checked_weight(connection, features, weight);
  const at::Tensor shift =
      checked_vector(bias, kernel, "expected one bias an output channel, like the weights");
  return SparseConvolution::apply(
      features, kernel, shift.defined() ? shift : at::empty({0}, kernel.options()), connection);
}

at::Tensor convolve_fused(const Connection& connection, const at::Tensor& features,
                          const at::Tensor& weight, const FusedEpilogue& epilogue) {
  const at::Tensor kernel = checked_weight(connection, features, weight.detach());
  const char* expected = "expected one scale and shift an output channel, like the weights";
  const FusedEpilogue checked{
      .scale = checked_vector(epilogue.scale.defined() ? epilogue.scale.detach() : at::Tensor(),
                              kernel, expected),
      .shift = checked_vector(epilogue.shift.defined() ? epilogue.shift.detach() : at::Tensor(),
                              kernel, expected),
      .residual = epilogue.residual.defined() ? epilogue.residual.detach() : at::Tensor(),
      .relu = epilogue.relu};
  if (checked.residual.defined() &&
      (checked.residual.dim() != 2 || checked.residual.size(0) != connection.outputs->size() ||
       checked.residual.size(1) != kernel.size(2) ||
       checked.residual.scalar_type() != kernel.scalar_type())) {
    refuse("expected a residual (outputs, out_channels) of the weights' type", checked.residual);
  }
  if (runs_own_kernels(features)) {
    return own_forward(connection, features.detach(), kernel, checked);
  }
  at::Tensor result = internal::plain_convolve(connection, features.detach(), kernel);
  if (checked.scale.defined()) result.mul_(checked.scale);
  if (checked.shift.defined()) result.add_(checked.shift);
  if (checked.residual.defined()) result.add_(checked.residual);
  return checked.relu ? result.relu_() : result;
}

SparseTensor convolution(const SparseTensor& input, const at::Tensor& weight, const Kernel& kernel,
                         const at::Tensor& bias) {
  const Connection connection = input.manager().convolution(input.set(), kernel);
  return {connection.outputs, convolve(connection, input.features(), weight, bias), input};
}

SparseTensor transposed_convolution(const SparseTensor& input, const SparseTensor& target,
                                    const at::Tensor& weight, const Kernel& kernel,
                                    const at::Tensor& bias) {
  const Connection connection = input.manager().transposed(input.set(), target.set(), kernel);
  return {connection.outputs, convolve(connection, input.features(), weight, bias), input};
}

SparseTensor generative_convolution(const SparseTensor& input, const at::Tensor& weight,
                                    const Kernel& kernel, const at::Tensor& bias) {
  const Connection connection = input.manager().generative(input.set(), kernel);
  return {connection.outputs, convolve(connection, input.features(), weight, bias), input};
}

}  // namespace arbox::sparse
