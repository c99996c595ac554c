#include "arbox/sparse/pooling.h"

#include <ATen/Dispatch.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/full.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/sparse/internal/held_connection.h"

namespace arbox::sparse {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Visits the pairs whose position on the side `to` lies in [begin, end), element by element.
template <class Visit>
void visit_pairs(const KernelMap& map, const std::vector<std::int32_t>& to, std::int64_t begin,
                 std::int64_t end, Visit visit) {
  for (std::int64_t k = 0; k < map.elements(); ++k) {
    const auto* last = to.data() + map.starts[k + 1];
    const auto* p =
        std::lower_bound(to.data() + map.starts[k], last, static_cast<std::int32_t>(begin));
    for (; p != last && *p < end; ++p) visit(p - to.data());
  }
}

template <class Scalar>
void maxima(const Connection& connection, const at::Tensor& features, at::Tensor& result,
            at::Tensor& winners) {
  const KernelMap& map = *connection.map;
  const std::int64_t channels = features.size(1);
  const Scalar* from = features.data_ptr<Scalar>();
  Scalar* to = result.data_ptr<Scalar>();
  auto* winner = winners.data_ptr<std::int32_t>();
  const auto& inputs = connection.inputs->sorted().rows;
  const auto& outputs = connection.outputs->sorted().rows;
  parallel_for(connection.outputs->size(), 256, 0, [&](std::int64_t begin, std::int64_t end) {
    visit_pairs(map, map.outputs, begin, end, [&](std::int64_t p) {
      const std::int32_t input = inputs[map.inputs[p]];
      const std::int64_t output = std::int64_t{outputs[map.outputs[p]]} * channels;
      const Scalar* row = from + input * channels;
      for (std::int64_t c = 0; c < channels; ++c) {
        const Scalar best = to[output + c];
        if (winner[output + c] >= 0 && (row[c] <= best || best != best)) continue;
        to[output + c] = row[c];
        winner[output + c] = input;
      }
    });
  });
}

template <class Scalar>
void route_gradient(const Connection& connection, const at::Tensor& gradient,
                    const at::Tensor& winners, at::Tensor& result) {
  const KernelMap& map = *connection.map;
  const std::int64_t channels = gradient.size(1);
  const Scalar* from = gradient.data_ptr<Scalar>();
  Scalar* to = result.data_ptr<Scalar>();
  const auto* winner = winners.data_ptr<std::int32_t>();
  const auto& inputs = connection.inputs->sorted().rows;
  const auto& outputs = connection.outputs->sorted().rows;
  parallel_for(connection.inputs->size(), 256, 0, [&](std::int64_t begin, std::int64_t end) {
    visit_pairs(map, map.inputs, begin, end, [&](std::int64_t p) {
      const std::int32_t input = inputs[map.inputs[p]];
      const std::int64_t output = std::int64_t{outputs[map.outputs[p]]} * channels;
      for (std::int64_t c = 0; c < channels; ++c) {
        if (winner[output + c] == input) to[input * channels + c] += from[output + c];
      }
    });
  });
}

class MaxPool : public torch::autograd::Function<MaxPool> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& features,
                            const Connection& connection) {
    const at::Tensor input = features.contiguous();
    at::Tensor result =
        at::empty({connection.outputs->size(), features.size(1)}, features.options());
    at::Tensor winners = at::full(result.sizes(), -1, at::kInt);
    AT_DISPATCH_FLOATING_TYPES(features.scalar_type(), "max_pool",
                               [&] { maxima<scalar_t>(connection, input, result, winners); });
    context->saved_data["winners"] = winners;
    context->saved_data["connection"] = internal::hold(connection);
    return result;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const at::Tensor gradient = gradients[0].contiguous();
    const Connection connection = internal::held(context->saved_data["connection"]);
    at::Tensor result =
        at::zeros({connection.inputs->size(), gradient.size(1)}, gradient.options());
    AT_DISPATCH_FLOATING_TYPES(gradient.scalar_type(), "max_pool", [&] {
      route_gradient<scalar_t>(connection, gradient, context->saved_data["winners"].toTensor(),
                               result);
    });
    return {result, at::Tensor()};
  }
};

template <class Scalar>
void add_rows(const KernelMap& map, const std::vector<std::int32_t>& from_positions,
              const std::vector<std::int32_t>& to_positions,
              const std::vector<std::int32_t>& from_rows, const std::vector<std::int32_t>& to_rows,
              const at::Tensor& source, at::Tensor& result) {
  const std::int64_t channels = source.size(1);
  const Scalar* from = source.data_ptr<Scalar>();
  Scalar* to = result.data_ptr<Scalar>();
  const auto count = static_cast<std::int64_t>(to_rows.size());
  parallel_for(count, 256, 0, [&](std::int64_t begin, std::int64_t end) {
    visit_pairs(map, to_positions, begin, end, [&](std::int64_t p) {
      const Scalar* row = from + std::int64_t{from_rows[from_positions[p]]} * channels;
      Scalar* sum = to + std::int64_t{to_rows[to_positions[p]]} * channels;
      for (std::int64_t c = 0; c < channels; ++c) sum[c] += row[c];
    });
  });
}

class SumPool : public torch::autograd::Function<SumPool> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& features,
                            const Connection& connection) {
    context->saved_data["connection"] = internal::hold(connection);
    const at::Tensor input = features.contiguous();
    at::Tensor result =
        at::zeros({connection.outputs->size(), features.size(1)}, features.options());
    const KernelMap& map = *connection.map;
    AT_DISPATCH_FLOATING_TYPES(features.scalar_type(), "average_pool", [&] {
      add_rows<scalar_t>(map, map.inputs, map.outputs, connection.inputs->sorted().rows,
                         connection.outputs->sorted().rows, input, result);
    });
    return result;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const at::Tensor gradient = gradients[0].contiguous();
    const Connection connection = internal::held(context->saved_data["connection"]);
    at::Tensor result =
        at::zeros({connection.inputs->size(), gradient.size(1)}, gradient.options());
    const KernelMap& map = *connection.map;
    AT_DISPATCH_FLOATING_TYPES(gradient.scalar_type(), "average_pool", [&] {
      add_rows<scalar_t>(map, map.outputs, map.inputs, connection.outputs->sorted().rows,
                         connection.inputs->sorted().rows, gradient, result);
    });
    return {result, at::Tensor()};
  }
};

void require_cpu(const SparseTensor& input, const char* what) {
  if (!input.features().is_cpu()) {
    throw NotAvailable(std::string(what) + ": only the CPU is supported, got " +
                       input.features().device().str());
  }
  if (input.features().scalar_type() != at::kFloat &&
      input.features().scalar_type() != at::kDouble) {
    throw InvalidArgument(std::string(what) + ": expected float32 or float64 features");
  }
}

at::Tensor window_sizes(const Connection& connection, const at::TensorOptions& options) {
  at::Tensor counts = at::zeros({connection.outputs->size(), 1}, at::kFloat);
  float* count = counts.data_ptr<float>();
  const auto& rows = connection.outputs->sorted().rows;
  for (const std::int32_t position : connection.map->outputs) count[rows[position]] += 1;
  return counts.to(options);
}

}  // namespace

SparseTensor max_pool(const SparseTensor& input, const Kernel& kernel) {
  require_cpu(input, "max_pool");
  const Connection connection = input.manager().convolution(input.set(), kernel);
  return {connection.outputs, MaxPool::apply(input.features(), connection), input};
}

SparseTensor average_pool(const SparseTensor& input, const Kernel& kernel) {
  require_cpu(input, "average_pool");
  const Connection connection = input.manager().convolution(input.set(), kernel);
  const at::Tensor sums = SumPool::apply(input.features(), connection);
  return {connection.outputs, sums.div(window_sizes(connection, sums.options())), input};
}

}  // namespace arbox::sparse
