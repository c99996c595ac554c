#include "arbox/sparse/kernel_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "arbox/base/error.h"
#include "arbox/sparse/coordinate_manager.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;
using Position = std::array<std::int32_t, 4>;

struct MapCase {
  const char* name;
  Kernel kernel;
  Lattice lattice;
  std::size_t voxels = 400;
};

std::vector<MapCase> map_cases() {
  const Lattice finest, coarse{.stride = {4, 2, 8}};
  const Lattice grid{.grid = Triple{12, 11, 10}};
  return {{"odd", {}, finest},
          {"even", {.size = {2, 2, 2}}, finest},
          {"even_strided", {.size = {2, 2, 2}, .stride = {2, 2, 2}}, finest},
          {"odd_strided", {.stride = {2, 2, 2}}, finest},
          {"shortcut", {.size = {1, 1, 1}, .stride = {2, 2, 2}}, finest},
          {"anisotropic", {.size = {3, 1, 1}, .stride = {2, 1, 1}}, finest},
          {"large", {.size = {5, 3, 4}, .stride = {3, 1, 2}}, finest},
          {"dilated", {.dilation = {2, 1, 3}}, finest},
          {"dilated_strided", {.stride = {2, 2, 2}, .dilation = {2, 2, 2}}, coarse},
          {"coarse", {}, coarse},
          {"one", {}, finest, 1},
          {"none", {}, finest, 0},
          {"submanifold", {.submanifold = true}, grid},
          {"submanifold_dilated", {.dilation = {2, 1, 2}, .submanifold = true}, grid},
          {"submanifold_even", {.size = {2, 4, 2}, .submanifold = true}, grid},
          {"padded", {.stride = {2, 2, 2}, .padding = {1, 1, 1}}, grid},
          {"padded_unevenly", {.stride = {2, 2, 2}, .padding = {0, 1, 1}}, grid},
          {"height_only", {.size = {1, 1, 3}, .stride = {1, 1, 2}}, grid},
          {"not_padded", {.size = {2, 3, 4}, .dilation = {1, 2, 1}}, grid},
          {"grid_none", {.stride = {2, 2, 2}, .padding = {1, 1, 1}}, grid, 0}};
}

CoordinateSetPtr made_set(const MapCase& test) {
  std::vector<Coordinate> voxels;
  for (Coordinate c :
       random_voxels(3, test.voxels, 2, test.lattice.grid ? 0 : -6, test.lattice.grid ? 10 : 12)) {
    if (!test.lattice.grid) {
      c.x *= test.lattice.stride[0];
      c.y *= test.lattice.stride[1];
      c.z *= test.lattice.stride[2];
    }
    voxels.push_back(c);
  }
  return std::make_shared<const CoordinateSet>(voxels, test.lattice);
}

Position position(const Coordinate& c) { return {c.batch, c.x, c.y, c.z}; }

/// The input that element (x, y, z) reads for an output, by the definitions of docs/sparse.md.
Position read_by(const MapCase& test, const Position& output, const Triple& element) {
  Position input = output;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t size = test.kernel.size[axis], dilation = test.kernel.dilation[axis];
    if (!test.lattice.grid) {
      const std::int32_t centre = size % 2 == 1 ? size / 2 : 0;
      input[axis + 1] += (element[axis] - centre) * dilation * test.lattice.stride[axis];
    } else {
      const std::int32_t padding =
          test.kernel.submanifold ? size / 2 * dilation : test.kernel.padding[axis];
      input[axis + 1] =
          output[axis + 1] * test.kernel.stride[axis] - padding + element[axis] * dilation;
    }
  }
  return input;
}

class KernelMaps : public ::testing::TestWithParam<MapCase> {};

TEST_P(KernelMaps, HoldThePairsThatTheDefinitionNames) {
  const MapCase& test = GetParam();
  const CoordinateSetPtr set = made_set(test);
  CoordinateManager manager;
  const Connection connection = manager.convolution(set, test.kernel);
  const KernelMap& map = *connection.map;
  ASSERT_EQ(map.elements(), test.kernel.elements());
  std::set<Position> inputs;
  for (const Coordinate& c : set->sorted().coordinates) inputs.insert(position(c));
  std::int64_t pairs = 0, k = 0;
  for (std::int32_t z = 0; z < test.kernel.size[2]; ++z) {
    for (std::int32_t y = 0; y < test.kernel.size[1]; ++y) {
      for (std::int32_t x = 0; x < test.kernel.size[0]; ++x, ++k) {
        std::int64_t p = map.starts[k];
        const auto& outputs = connection.outputs->sorted().coordinates;
        for (std::size_t o = 0; o < outputs.size(); ++o) {
          const Position input = read_by(test, position(outputs[o]), {x, y, z});
          if (!inputs.contains(input)) continue;
          ASSERT_LT(p, map.starts[k + 1]);
          EXPECT_EQ(map.outputs[p], static_cast<std::int32_t>(o));
          EXPECT_EQ(position(set->sorted().coordinates[map.inputs[p]]), input);
          ++p;
          ++pairs;
        }
        EXPECT_EQ(p, map.starts[k + 1]);
      }
    }
  }
  EXPECT_EQ(pairs, map.pairs());
}

TEST_P(KernelMaps, OutputsAreWhatTheRuleSays) {
  const MapCase& test = GetParam();
  const CoordinateSetPtr set = made_set(test);
  CoordinateManager manager;
  const Connection connection = manager.convolution(set, test.kernel);
  std::set<Position> expected;
  for (const Coordinate& c : set->sorted().coordinates) {
    if (!test.lattice.grid) {
      Position output = position(c);
      for (int axis = 0; axis < 3; ++axis) {
        const std::int32_t stride = test.kernel.stride[axis] * test.lattice.stride[axis];
        output[axis + 1] =
            static_cast<std::int32_t>(std::floor(output[axis + 1] / double(stride))) * stride;
      }
      expected.insert(output);
    } else if (test.kernel.submanifold) {
      expected.insert(position(c));
    }
  }
  if (test.lattice.grid && !test.kernel.submanifold) {
    std::set<Position> inputs;
    for (const Coordinate& c : set->sorted().coordinates) inputs.insert(position(c));
    const Triple cells = *connection.outputs->lattice().grid;
    for (std::int32_t batch = 0; batch < 2; ++batch) {
      for (std::int32_t x = 0; x < cells[0]; ++x) {
        for (std::int32_t y = 0; y < cells[1]; ++y) {
          for (std::int32_t z = 0; z < cells[2]; ++z) {
            for (std::int64_t k = 0; k < test.kernel.elements(); ++k) {
              const auto& size = test.kernel.size;
              const Triple element{static_cast<std::int32_t>(k % size[0]),
                                   static_cast<std::int32_t>(k / size[0] % size[1]),
                                   static_cast<std::int32_t>(k / size[0] / size[1])};
              if (!inputs.contains(read_by(test, {batch, x, y, z}, element))) continue;
              expected.insert({batch, x, y, z});
            }
          }
        }
      }
    }
  }
  std::set<Position> outputs;
  for (const Coordinate& c : connection.outputs->sorted().coordinates) outputs.insert(position(c));
  EXPECT_EQ(outputs, expected);
  EXPECT_EQ(outputs.size(), connection.outputs->sorted().coordinates.size());
}

INSTANTIATE_TEST_SUITE_P(Kernels, KernelMaps, ::testing::ValuesIn(map_cases()),
                         [](const auto& test) { return test.param.name; });

TEST(KernelMap, IsTheSameAtAnyThreadCount) {
  const CoordinateSet set(random_voxels(4, 3000, 2, -10, 20), {});
  const KernelGeometry geometry = kernel_geometry({}, {});
  const KernelMap one = build_kernel_map(set.sorted(), set.sorted(), geometry, 1);
  const KernelMap four = build_kernel_map(set.sorted(), set.sorted(), geometry, 4);
  EXPECT_EQ(one.inputs, four.inputs);
  EXPECT_EQ(one.outputs, four.outputs);
  EXPECT_EQ(one.starts, four.starts);
}

TEST(KernelMap, SymmetricSearchEqualsTheFullSearch) {
  const CoordinateSet set(random_voxels(5, 2000, 2, -8, 16), {});
  const CoordinateSet copy = set;
  const KernelGeometry geometry = kernel_geometry({.size = {3, 5, 1}}, {});
  const KernelMap half = build_kernel_map(set.sorted(), set.sorted(), geometry);
  const KernelMap full = build_kernel_map(set.sorted(), copy.sorted(), geometry);
  EXPECT_EQ(half.inputs, full.inputs);
  EXPECT_EQ(half.outputs, full.outputs);
  EXPECT_EQ(half.starts, full.starts);
}

TEST(CoordinateManager, SharesMapsAndOutputs) {
  CoordinateManager manager;
  const auto set =
      std::make_shared<const CoordinateSet>(random_voxels(6, 300, 1, 0, 16), Lattice{});
  const Connection down = manager.convolution(set, {.stride = {2, 2, 2}});
  EXPECT_EQ(down.map, manager.convolution(set, {.stride = {2, 2, 2}}).map);
  const Connection shortcut = manager.convolution(set, {.size = {1, 1, 1}, .stride = {2, 2, 2}});
  EXPECT_EQ(down.outputs, shortcut.outputs);
  EXPECT_EQ(manager.maps(), 2u);
  EXPECT_EQ(manager.convolution(set, {}).outputs, set);
  manager.clear();
  EXPECT_EQ(manager.maps(), 0u);
}

TEST(CoordinateManager, TransposedMapsAreForwardMapsTurnedRound) {
  CoordinateManager manager;
  const auto set =
      std::make_shared<const CoordinateSet>(random_voxels(7, 300, 2, -8, 16), Lattice{});
  const Kernel kernel{.stride = {2, 2, 2}};
  const Connection down = manager.convolution(set, kernel);
  const Connection up = manager.transposed(down.outputs, set, kernel);
  EXPECT_EQ(up.map->inputs, down.map->outputs);
  EXPECT_EQ(up.map->outputs, down.map->inputs);
  EXPECT_EQ(up.outputs, set);
  EXPECT_THROW(manager.transposed(set, set, kernel), InvalidArgument);
}

TEST(CoordinateManager, GenerativeMapsReachAllChildrenOnce) {
  CoordinateManager manager;
  const auto set = std::make_shared<const CoordinateSet>(random_voxels(8, 200, 2, -8, 16, 4),
                                                         Lattice{.stride = {4, 4, 4}});
  const Connection two = manager.generative(set, {.size = {2, 2, 2}, .stride = {2, 2, 2}});
  EXPECT_EQ(two.outputs->size(), 8 * set->size());
  EXPECT_EQ(two.map->pairs(), 8 * set->size());
  EXPECT_EQ(two.outputs->lattice().stride, (Triple{2, 2, 2}));
  for (std::int64_t k = 0; k < 8; ++k) {
    for (std::int64_t p = two.map->starts[k]; p < two.map->starts[k + 1]; ++p) {
      const Coordinate parent = set->sorted().coordinates[two.map->inputs[p]];
      const Coordinate child = two.outputs->sorted().coordinates[two.map->outputs[p]];
      EXPECT_EQ(child, (Coordinate{parent.batch, parent.x + 2 * static_cast<int>(k % 2),
                                   parent.y + 2 * static_cast<int>(k / 2 % 2),
                                   parent.z + 2 * static_cast<int>(k / 4)}));
    }
  }
  const Connection three = manager.generative(set, {.stride = {2, 2, 2}});
  EXPECT_EQ(three.map->pairs(), 27 * set->size());
  EXPECT_LT(three.outputs->size(), 27 * set->size());
  EXPECT_THROW(manager.generative(set, {.stride = {3, 3, 3}}), InvalidArgument);
}

TEST(Kernel, BadShapesAreRefused) {
  const Lattice grid{.grid = Triple{4, 4, 2}};
  EXPECT_THROW(require_kernel({.size = {0, 3, 3}}, {}), InvalidArgument);
  EXPECT_THROW(require_kernel({.stride = {1, -1, 1}}, {}), InvalidArgument);
  EXPECT_THROW(require_kernel({.dilation = {1, 1, 1 << 20}}, {}), InvalidArgument);
  EXPECT_THROW(require_kernel({.padding = {1, 1, 1}}, {}), InvalidArgument);
  EXPECT_THROW(require_kernel({.submanifold = true}, {}), InvalidArgument);
  EXPECT_THROW(require_kernel({.stride = {2, 2, 2}, .submanifold = true}, grid), InvalidArgument);
  EXPECT_THROW(output_lattice({}, grid), InvalidArgument);
}

}  // namespace
