#include "arbox/sparse/coordinates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "arbox/base/error.h"
#include "arbox/sparse/coordinate_set.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;

TEST(Coordinates, SortLikeTuplesOfAnySign) {
  const auto voxels = random_voxels(1, 5000, 3, -40, 80);
  const SortedCoordinates sorted = sort_coordinates(voxels);
  auto expected = voxels;
  std::sort(expected.begin(), expected.end(), [](const Coordinate& a, const Coordinate& b) {
    return std::tie(a.batch, a.x, a.y, a.z) < std::tie(b.batch, b.x, b.y, b.z);
  });
  EXPECT_EQ(sorted.coordinates, expected);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_EQ(sorted.coordinates[i], voxels[sorted.rows[i]]);
  }
}

TEST(Coordinates, EqualOnesKeepTheirOrder) {
  const std::vector<Coordinate> voxels = {{0, 1, 1, 1}, {0, 0, 0, 0}, {0, 1, 1, 1}, {0, 0, 0, 0}};
  EXPECT_EQ(sort_coordinates(voxels).rows, (std::vector<std::int32_t>{1, 3, 0, 2}));
  EXPECT_EQ(unique_coordinates(voxels).coordinates,
            (std::vector<Coordinate>{{0, 0, 0, 0}, {0, 1, 1, 1}}));
}

TEST(Coordinates, NoneAndOne) {
  EXPECT_TRUE(sort_coordinates({}).rows.empty());
  EXPECT_TRUE(unique_coordinates({}).rows.empty());
  const std::vector<Coordinate> one = {{7, -5, 1 << 29, 3}};
  EXPECT_EQ(sort_coordinates(one).coordinates, one);
  EXPECT_EQ(unique_coordinates(one).coordinates, one);
}

TEST(Coordinates, ExtentsUpToTwoToTheTwentyFitAndMoreIsRefused) {
  const std::int32_t wide = 1 << 20;
  const std::vector<Coordinate> fits = {{0, -wide / 2, 0, wide - 1},
                                        {0, wide / 2 - 1, wide - 1, 0}};
  EXPECT_EQ(unique_coordinates(fits).coordinates.size(), 2u);
  EXPECT_EQ(sort_coordinates(fits).coordinates[0], fits[0]);
  const std::vector<Coordinate> too_wide = {{0, 0, 0, 0}, {0, 0, wide, 0}};
  EXPECT_THROW(sort_coordinates(too_wide), InvalidArgument);
  const std::int32_t most = std::numeric_limits<std::int32_t>::max();
  EXPECT_THROW(sort_coordinates(std::vector<Coordinate>{{0, most, 0, 0}}), InvalidArgument);
  const std::vector<Coordinate> many_batches = {{0, 0, 0, 0},
                                                {1 << 20, wide - 1, wide - 1, wide - 1}};
  EXPECT_THROW(sort_coordinates(many_batches), InvalidArgument);
}

TEST(KeyLayout, PacksInOrderAndUnpacks) {
  const KeyLayout layout({0, -10, -20, -30}, {4, 100, 200, 300}, 2);
  const Coordinate a{2, -3, 7, 9};
  EXPECT_EQ(layout.unpack(layout.pack(a)), a);
  EXPECT_EQ(layout.pack({2, -4, 9, 6}), layout.pack(a) + layout.delta(-1, 2, -3));
  EXPECT_LT(layout.pack({2, -3, 7, 9}), layout.pack({2, -3, 8, -30}));
  EXPECT_LT(layout.pack({1, 100, 200, 300}), layout.pack({2, -10, -20, -30}));
}

TEST(CoordinateSet, RemembersRowsAndCountsBatches) {
  const auto voxels = random_voxels(2, 100, 2, -5, 10, 4);
  const CoordinateSet set(voxels, {.stride = {4, 4, 4}});
  EXPECT_EQ(set.in_rows(), voxels);
  EXPECT_EQ(set.batch_size(), 2);
  EXPECT_EQ(CoordinateSet(std::span<const Coordinate>{}, {}).batch_size(), 0);
}

TEST(CoordinateSet, RefusesWhatIsNoSetOnItsLattice) {
  const auto make = [](std::vector<Coordinate> voxels, const Lattice& lattice) {
    return CoordinateSet(voxels, lattice);
  };
  EXPECT_THROW(make({{0, 1, 2, 3}, {0, 1, 2, 3}}, {}), InvalidArgument);
  EXPECT_THROW(make({{-1, 1, 2, 3}}, {}), InvalidArgument);
  EXPECT_THROW(make({{0, 1, 2, 4}}, {.stride = {2, 2, 2}}), InvalidArgument);
  EXPECT_THROW(make({{0, 1, 2, 4}}, {.stride = {0, 1, 1}}), InvalidArgument);
  EXPECT_THROW(make({{0, 4, 2, 2}}, {.grid = Triple{4, 4, 4}}), InvalidArgument);
  EXPECT_THROW(make({{0, -1, 2, 2}}, {.grid = Triple{4, 4, 4}}), InvalidArgument);
}

}  // namespace
