#include "arbox/sparse/internal/plain_convolution.h"

#include <ATen/ops/empty.h>
#include <ATen/ops/mm.h>
#include <ATen/ops/zeros.h>

namespace arbox::sparse::internal {
namespace {

at::Tensor rows_of(std::span<const std::int32_t> positions, std::span<const std::int32_t> rows,
                   const at::Device& device) {
  at::Tensor result = at::empty({static_cast<std::int64_t>(positions.size())}, at::kLong);
  auto* to = result.data_ptr<std::int64_t>();
  for (const std::int32_t position : positions) *to++ = rows[position];
  return result.to(device);
}

struct ElementRows {
  at::Tensor inputs, outputs;
};

ElementRows element_rows(const Connection& connection, std::int64_t k, const at::Device& device) {
  const KernelMap& map = *connection.map;
  const std::int64_t begin = map.starts[k], count = map.starts[k + 1] - begin;
  return {rows_of({map.inputs.data() + begin, static_cast<std::size_t>(count)},
                  connection.inputs->sorted().rows, device),
          rows_of({map.outputs.data() + begin, static_cast<std::size_t>(count)},
                  connection.outputs->sorted().rows, device)};
}

}  // namespace

at::Tensor plain_convolve(const Connection& connection, const at::Tensor& features,
                          const at::Tensor& weight) {
  at::Tensor result = at::zeros({connection.outputs->size(), weight.size(2)}, features.options());
  for (std::int64_t k = 0; k < connection.map->elements(); ++k) {
    const ElementRows rows = element_rows(connection, k, features.device());
    result.index_add_(0, rows.outputs, at::mm(features.index_select(0, rows.inputs), weight[k]));
  }
  return result;
}

at::Tensor plain_input_gradient(const Connection& connection, const at::Tensor& gradient,
                                const at::Tensor& weight) {
  at::Tensor result = at::zeros({connection.inputs->size(), weight.size(1)}, gradient.options());
  for (std::int64_t k = 0; k < connection.map->elements(); ++k) {
    const ElementRows rows = element_rows(connection, k, gradient.device());
    result.index_add_(0, rows.inputs,
                      at::mm(gradient.index_select(0, rows.outputs), weight[k].t()));
  }
  return result;
}

at::Tensor plain_weight_gradient(const Connection& connection, const at::Tensor& features,
                                 const at::Tensor& gradient) {
  at::Tensor result = at::zeros({connection.map->elements(), features.size(1), gradient.size(1)},
                                features.options());
  for (std::int64_t k = 0; k < connection.map->elements(); ++k) {
    const ElementRows rows = element_rows(connection, k, gradient.device());
    result[k] =
        at::mm(features.index_select(0, rows.inputs).t(), gradient.index_select(0, rows.outputs));
  }
  return result;
}

}  // namespace arbox::sparse::internal
