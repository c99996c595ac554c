#include "arbox/sparse/voxel_tensor.h"

#include <ATen/ops/empty.h>

#include <algorithm>

#include "arbox/base/error.h"

namespace arbox::sparse {

SparseTensor to_sparse_tensor(std::span<const Voxels> scenes, const Lattice& lattice) {
  const std::int32_t columns = scenes.empty() ? 3 : scenes.front().columns;
  std::vector<Coordinate> coordinates;
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    if (scenes[scene].columns != columns) {
      throw InvalidArgument("to_sparse_tensor: scene " + std::to_string(scene) + " has " +
                            std::to_string(scenes[scene].columns) + " columns, scene 0 has " +
                            std::to_string(columns));
    }
    for (Coordinate c : scenes[scene].coordinates) {
      c.batch = static_cast<std::int32_t>(scene);
      coordinates.push_back(c);
    }
  }
  at::Tensor features =
      at::empty({static_cast<std::int64_t>(coordinates.size()), columns}, at::kFloat);
  float* to = features.data_ptr<float>();
  for (const Voxels& scene : scenes) {
    to = std::copy(scene.features.begin(), scene.features.end(), to);
  }
  return {to_tensor(coordinates), std::move(features), lattice,
          static_cast<std::int64_t>(scenes.size())};
}

}  // namespace arbox::sparse
