#include <ATen/TensorOperators.h>
#include <ATen/ops/zeros.h>

#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include "arbox/base/error.h"
#include "arbox/sparse/voxel_sets.h"

namespace arbox::sparse {
namespace {

// Places beyond this are far from every voxel, and so is their cell.
constexpr double kFarthestPlace = 1 << 29;

struct Corners {
  std::vector<Coordinate> cells;                // lowest corner of each place
  std::vector<std::array<double, 3>> fraction;  // position in the cell, 0 to 1
  std::vector<bool> known;                      // finite and near enough to be looked up
};

Corners corners_of(const at::Tensor& places, const Triple& stride) {
  const at::Tensor table = places.detach().to(at::kCPU, at::kDouble).contiguous();
  const double* row = table.data_ptr<double>();
  Corners result;
  result.cells.resize(table.size(0));
  result.fraction.resize(table.size(0));
  result.known.resize(table.size(0));
  for (std::size_t i = 0; i < result.cells.size(); ++i, row += 4) {
    std::array<std::int32_t, 3> low{};
    bool known = row[0] >= 0 && row[0] < kFarthestPlace;
    for (int axis = 0; axis < 3; ++axis) {
      const double value = row[axis + 1];
      known = known && std::abs(value) < kFarthestPlace;
      if (!known) break;
      const double cell = std::floor(value / stride[axis]);
      low[axis] = static_cast<std::int32_t>(cell) * stride[axis];
      result.fraction[i][axis] = value / stride[axis] - cell;
    }
    result.known[i] = known;
    if (known) result.cells[i] = {static_cast<std::int32_t>(row[0]), low[0], low[1], low[2]};
  }
  return result;
}

/// For each place the rows of the 8 corners of its cell; -1 for absent ones.
std::vector<std::array<std::int64_t, 8>> corner_rows(const SparseTensor& tensor,
                                                     const Corners& corners, const Triple& stride) {
  const SortedCoordinates cells = unique_coordinates(corners.cells);
  KernelGeometry geometry;
  for (int corner = 0; corner < 8; ++corner) {
    geometry.offsets.push_back(
        {(corner & 1) * stride[0], (corner >> 1 & 1) * stride[1], (corner >> 2) * stride[2]});
  }
  const SortedCoordinates& sorted = tensor.set()->sorted();
  const KernelMap map = build_kernel_map(sorted, cells, geometry);
  std::array<std::int64_t, 8> none;
  none.fill(-1);
  std::vector<std::array<std::int64_t, 8>> of_cells(cells.rows.size(), none);
  for (int corner = 0; corner < 8; ++corner) {
    for (std::int64_t p = map.starts[corner]; p < map.starts[corner + 1]; ++p) {
      of_cells[map.outputs[p]][corner] = sorted.rows[map.inputs[p]];
    }
  }
  const SortedCoordinates order = sort_coordinates(corners.cells);
  std::vector<std::array<std::int64_t, 8>> result(corners.cells.size(), none);
  std::size_t cell = 0;
  for (std::size_t i = 0; i < order.rows.size(); ++i) {
    while (!(cells.coordinates[cell] == order.coordinates[i])) ++cell;
    if (corners.known[order.rows[i]]) result[order.rows[i]] = of_cells[cell];
  }
  return result;
}

}  // namespace

at::Tensor interpolate(const SparseTensor& tensor, const at::Tensor& places) {
  if (places.dim() != 2 || places.size(1) != 4) {
    std::ostringstream text;
    text << "interpolate: expected places (M, 4), got " << places.sizes();
    throw InvalidArgument(text.str());
  }
  const Triple stride = tensor.lattice().grid ? Triple{1, 1, 1} : tensor.lattice().stride;
  const Corners corners = corners_of(places, stride);
  const std::int64_t count = places.size(0);
  const at::Tensor& features = tensor.features();
  if (tensor.size() == 0 || count == 0) {
    return at::zeros({count, tensor.channels()}, features.options());
  }
  const auto rows = corner_rows(tensor, corners, stride);
  at::Tensor index = at::zeros({count * 8}, at::kLong);
  at::Tensor weights = at::zeros({count, 8, 1}, at::kDouble);
  auto* to_index = index.data_ptr<std::int64_t>();
  auto* to_weight = weights.data_ptr<double>();
  for (std::int64_t i = 0; i < count; ++i) {
    for (int corner = 0; corner < 8; ++corner, ++to_index, ++to_weight) {
      if (rows[i][corner] < 0) continue;
      *to_index = rows[i][corner];
      *to_weight = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const double fraction = corners.fraction[i][axis];
        *to_weight *= (corner >> axis & 1) != 0 ? fraction : 1 - fraction;
      }
    }
  }
  return (features.index_select(0, index.to(features.device())).view({count, 8, -1}) *
          weights.to(features.options()))
      .sum(1);
}

}  // namespace arbox::sparse
