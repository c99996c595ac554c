#include "arbox/sparse/voxel_sets.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/ivalue.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/nonzero.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "arbox/base/error.h"

namespace arbox::sparse {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

at::Tensor to_index(const std::vector<std::int64_t>& values, const at::Device& device) {
  at::Tensor result = at::empty({static_cast<std::int64_t>(values.size())}, at::kLong);
  std::copy(values.begin(), values.end(), result.data_ptr<std::int64_t>());
  return result.to(device);
}

CoordinateSetPtr kept_set(const CoordinateSet& set, const bool* keep) {
  std::vector<std::int32_t> new_rows(set.size());
  std::int32_t kept = 0;
  for (std::int64_t row = 0; row < set.size(); ++row) new_rows[row] = keep[row] ? kept++ : -1;
  SortedCoordinates sorted;
  sorted.coordinates.reserve(kept);
  sorted.rows.reserve(kept);
  for (std::size_t i = 0; i < set.sorted().rows.size(); ++i) {
    const std::int32_t row = new_rows[set.sorted().rows[i]];
    if (row < 0) continue;
    sorted.coordinates.push_back(set.sorted().coordinates[i]);
    sorted.rows.push_back(row);
  }
  return std::make_shared<const CoordinateSet>(std::move(sorted), set.lattice());
}

struct Union {
  SortedCoordinates sorted;
  std::vector<std::int64_t> from_a, from_b;  // row of the union for each row of a and b
};

Union unite(const SortedCoordinates& a, const SortedCoordinates& b) {
  Union result;
  result.from_a.resize(a.rows.size());
  result.from_b.resize(b.rows.size());
  std::size_t i = 0, j = 0;
  std::int32_t row = 0;
  for (; i < a.rows.size() || j < b.rows.size(); ++row) {
    const bool end_a = i == a.rows.size(), end_b = j == b.rows.size();
    const bool take_a = !end_a && (end_b || a.coordinates[i] <= b.coordinates[j]);
    const bool take_b = !end_b && (end_a || b.coordinates[j] <= a.coordinates[i]);
    result.sorted.coordinates.push_back(take_a ? a.coordinates[i] : b.coordinates[j]);
    result.sorted.rows.push_back(row);
    if (take_a) result.from_a[a.rows[i++]] = row;
    if (take_b) result.from_b[b.rows[j++]] = row;
  }
  return result;
}

void refuse(const std::string& expected, const at::Tensor& tensor) {
  std::ostringstream text;
  text << expected << ", got " << tensor.scalar_type() << " " << tensor.sizes();
  throw InvalidArgument(text.str());
}

class UnionSum : public torch::autograd::Function<UnionSum> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& a, const at::Tensor& b,
                            const at::Tensor& from_a, const at::Tensor& from_b, std::int64_t rows) {
    context->saved_data["from_a"] = from_a;
    context->saved_data["from_b"] = from_b;
    at::Tensor sum = at::zeros({rows, a.size(1)}, a.options());
    sum.index_copy_(0, from_a, a);
    // Rows of b are distinct, so that a copy of the sums is a sum.
    return sum.index_copy_(0, from_b, sum.index_select(0, from_b).add_(b));
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    return {gradients[0].index_select(0, context->saved_data["from_a"].toTensor()),
            gradients[0].index_select(0, context->saved_data["from_b"].toTensor()), at::Tensor(),
            at::Tensor(), at::Tensor()};
  }
};

struct DenseRows {
  at::Tensor rows, cells;  // which rows of the tensor, and which cell (b, z, y, x) laid flat
};

DenseRows dense_rows(const SparseTensor& tensor, const DenseRegion& region) {
  const bool bounded = tensor.lattice().grid.has_value();
  const Triple stride = bounded ? Triple{1, 1, 1} : tensor.lattice().stride;
  const Triple& cells = region.cells;
  std::vector<std::int64_t> rows, flat;
  const SortedCoordinates& sorted = tensor.set()->sorted();
  for (std::size_t i = 0; i < sorted.rows.size(); ++i) {
    const Coordinate& c = sorted.coordinates[i];
    const Triple offset{c.x - region.low[0], c.y - region.low[1], c.z - region.low[2]};
    std::int64_t cell = c.batch;
    bool inside = true;
    for (int axis = 2; axis >= 0; --axis) {
      const std::int32_t index = offset[axis] / stride[axis];
      inside =
          inside && offset[axis] >= 0 && offset[axis] % stride[axis] == 0 && index < cells[axis];
      cell = cell * cells[axis] + index;
    }
    if (!inside) continue;
    rows.push_back(sorted.rows[i]);
    flat.push_back(cell);
  }
  const at::Device device = tensor.features().device();
  return {to_index(rows, device), to_index(flat, device)};
}

}  // namespace

SparseTensor prune(const SparseTensor& tensor, const at::Tensor& keep) {
  if (keep.dim() != 1 || keep.size(0) != tensor.size() || keep.scalar_type() != at::kBool) {
    refuse("prune: expected bool (" + std::to_string(tensor.size()) + ")", keep);
  }
  const at::Tensor here = keep.to(at::kCPU).contiguous();
  const at::Tensor rows = at::nonzero(here).squeeze(1).to(tensor.features().device());
  return {kept_set(*tensor.set(), here.data_ptr<bool>()), tensor.features().index_select(0, rows),
          tensor};
}

at::Tensor highest_in_each_scene(const SparseTensor& tensor, const at::Tensor& scores,
                                 std::int64_t count) {
  if (count < 0) throw InvalidArgument("highest_in_each_scene: count must not be negative");
  if (scores.dim() != 1 || scores.size(0) != tensor.size() || !scores.is_floating_point()) {
    refuse("highest_in_each_scene: expected floats (" + std::to_string(tensor.size()) + ")",
           scores);
  }
  const at::Tensor values = scores.detach().to(at::kCPU, at::kDouble).contiguous();
  const double* value = values.data_ptr<double>();
  at::Tensor result = at::zeros({tensor.size()}, at::kBool);
  bool* keep = result.data_ptr<bool>();
  const SortedCoordinates& sorted = tensor.set()->sorted();
  const auto higher = [value](std::int32_t a, std::int32_t b) {
    const bool no_a = value[a] != value[a], no_b = value[b] != value[b];
    if (no_a != no_b) return no_b;
    return value[a] != value[b] && !no_a ? value[a] > value[b] : a < b;
  };
  for (std::size_t begin = 0; begin < sorted.rows.size();) {
    std::size_t end = begin;
    while (end < sorted.rows.size() &&
           sorted.coordinates[end].batch == sorted.coordinates[begin].batch) {
      ++end;
    }
    std::vector<std::int32_t> rows(sorted.rows.begin() + begin, sorted.rows.begin() + end);
    const auto most = std::min<std::int64_t>(count, rows.size());
    if (most < static_cast<std::int64_t>(rows.size())) {
      std::nth_element(rows.begin(), rows.begin() + most, rows.end(), higher);
    }
    for (std::int64_t i = 0; i < most; ++i) keep[rows[i]] = true;
    begin = end;
  }
  return result.to(scores.device());
}

SparseTensor add(const SparseTensor& a, const SparseTensor& b) {
  if (a.lattice() != b.lattice() || a.channels() != b.channels()) {
    throw InvalidArgument("add: the tensors differ in stride, grid or channels (" +
                          std::to_string(a.channels()) + " and " + std::to_string(b.channels()) +
                          ")");
  }
  if (a.set() == b.set()) return a.with_features(a.features() + b.features());
  Union united = unite(a.set()->sorted(), b.set()->sorted());
  const auto rows = static_cast<std::int64_t>(united.sorted.rows.size());
  const at::Device device = a.features().device();
  at::Tensor sum = UnionSum::apply(a.features(), b.features(), to_index(united.from_a, device),
                                   to_index(united.from_b, device), rows);
  const SparseTensor& like = a.batch_size() >= b.batch_size() ? a : b;
  return {std::make_shared<const CoordinateSet>(std::move(united.sorted), a.lattice()),
          std::move(sum), like};
}

at::Tensor to_dense(const SparseTensor& tensor) {
  if (!tensor.lattice().grid) {
    throw InvalidArgument("to_dense: an unbounded tensor needs a region");
  }
  return to_dense(tensor, {.low = {0, 0, 0}, .cells = *tensor.lattice().grid});
}

at::Tensor to_dense(const SparseTensor& tensor, const DenseRegion& region) {
  const auto& [x, y, z] = region.cells;
  if (x < 1 || y < 1 || z < 1) throw InvalidArgument("to_dense: a region has at least one cell");
  const DenseRows places = dense_rows(tensor, region);
  const std::int64_t batch = tensor.batch_size(), channels = tensor.channels();
  return at::zeros({batch * z * y * x, channels}, tensor.features().options())
      .index_copy(0, places.cells, tensor.features().index_select(0, places.rows))
      .view({batch, z, y, x, channels})
      .permute({0, 4, 1, 2, 3});
}

SparseTensor from_dense(const at::Tensor& dense, const Lattice& lattice, const Triple& low,
                        const at::Tensor& occupied) {
  if (dense.dim() != 5 || !dense.is_floating_point()) {
    refuse("from_dense: expected floats (B, C, Z, Y, X)", dense);
  }
  const at::Tensor mask = occupied.defined() ? occupied : dense.detach().ne(0).any(1);
  const bool fits = mask.dim() == 4 && mask.scalar_type() == at::kBool &&
                    mask.size(0) == dense.size(0) && mask.size(1) == dense.size(2) &&
                    mask.size(2) == dense.size(3) && mask.size(3) == dense.size(4);
  if (!fits) refuse("from_dense: expected occupied as bool (B, Z, Y, X)", mask);
  const at::Tensor cells = at::nonzero(mask);
  const at::Tensor flat = at::nonzero(mask.reshape({-1})).squeeze(1);
  at::Tensor features =
      dense.permute({0, 2, 3, 4, 1}).reshape({-1, dense.size(1)}).index_select(0, flat);
  const at::Tensor here = cells.to(at::kCPU).contiguous();
  const auto* cell = here.data_ptr<std::int64_t>();
  std::vector<Coordinate> coordinates(here.size(0));
  const Triple stride = lattice.grid ? Triple{1, 1, 1} : lattice.stride;
  for (std::size_t i = 0; i < coordinates.size(); ++i, cell += 4) {
    coordinates[i] = {static_cast<std::int32_t>(cell[0]),
                      low[0] + static_cast<std::int32_t>(cell[3]) * stride[0],
                      low[1] + static_cast<std::int32_t>(cell[2]) * stride[1],
                      low[2] + static_cast<std::int32_t>(cell[1]) * stride[2]};
  }
  return {to_tensor(coordinates), std::move(features), lattice, dense.size(0)};
}

at::Tensor birds_eye(const SparseTensor& tensor) {
  const at::Tensor dense = to_dense(tensor);
  return dense.reshape(
      {dense.size(0), dense.size(1) * dense.size(2), dense.size(3), dense.size(4)});
}

}  // namespace arbox::sparse
