#include "arbox/sparse/voxelize.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;
using geometry::PointCloudView;

const std::vector<std::string> kIntensity = {"intensity"};

struct Naive {
  std::vector<Coordinate> coordinates;
  std::vector<std::vector<int>> points;
};

/// First come, first served, one point after the other.
Naive naive(const std::vector<float>& rows, const VoxelizeOptions& options) {
  Naive result;
  std::map<std::tuple<int, int, int>, std::size_t> known;
  for (std::size_t i = 0; i < rows.size() / 4; ++i) {
    int cell[3];
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      cell[axis] = static_cast<int>(std::floor((rows[4 * i + axis] - float(options.origin[axis])) /
                                               float(options.voxel_size[axis])));
      const int cells = options.grid[axis];
      inside = inside && (cells == 0 || (cell[axis] >= 0 && cell[axis] < cells));
    }
    if (!inside) continue;
    const auto key = std::make_tuple(cell[0], cell[1], cell[2]);
    if (!known.contains(key)) {
      if (options.max_voxels > 0 && known.size() == std::size_t(options.max_voxels)) continue;
      known[key] = result.points.size();
      result.points.emplace_back();
      result.coordinates.push_back({0, cell[0], cell[1], cell[2]});
    }
    auto& points = result.points[known[key]];
    if (options.max_points_per_voxel > 0 &&
        points.size() == std::size_t(options.max_points_per_voxel)) {
      continue;
    }
    points.push_back(static_cast<int>(i));
  }
  return result;
}

class VoxelizeCases : public ::testing::TestWithParam<VoxelizeOptions> {};

TEST_P(VoxelizeCases, EqualTheNaiveLoop) {
  const VoxelizeOptions& options = GetParam();
  const auto rows = random_numbers(1, 4 * 3000);
  const Voxels voxels =
      voxelize(PointCloudView::packed(rows.data(), 3000, kIntensity), kIntensity, options);
  const Naive expected = naive(rows, options);
  EXPECT_EQ(voxels.coordinates, expected.coordinates);
  ASSERT_EQ(voxels.columns, 4);
  for (std::size_t v = 0; v < voxels.size(); ++v) {
    const auto& points = expected.points[v];
    EXPECT_EQ(voxels.counts[v], static_cast<int>(points.size()));
    for (int column = 0; column < 4; ++column) {
      double mean = 0;
      bool of_a_point = false;
      for (const int point : points) {
        mean += rows[4 * point + column] / double(points.size());
        of_a_point = of_a_point || rows[4 * point + column] == voxels.features[4 * v + column];
        EXPECT_EQ(voxels.voxel_of_point[point], static_cast<int>(v));
      }
      const float feature = voxels.features[4 * v + column];
      if (options.feature == "mean") {
        EXPECT_NEAR(feature, mean, 1e-6);
      } else {
        EXPECT_TRUE(of_a_point);
      }
      if (options.feature == "first") {
        EXPECT_EQ(feature, rows[4 * points[0] + column]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Options, VoxelizeCases,
    ::testing::Values(
        VoxelizeOptions{.voxel_size = {0.2, 0.25, 0.3}},
        VoxelizeOptions{.voxel_size = {0.2, 0.2, 0.2}, .origin = {-1, -1, -1}, .grid = {9, 8, 7}},
        VoxelizeOptions{.voxel_size = {0.2, 0.2, 0.2},
                        .origin = {-1, -1, -1},
                        .grid = {10, 10, 10},
                        .max_points_per_voxel = 2,
                        .max_voxels = 150},
        VoxelizeOptions{.voxel_size = {0.5, 0.5, 0.5}, .feature = "first"},
        VoxelizeOptions{.voxel_size = {0.5, 0.5, 0.5}, .feature = "random", .seed = 7},
        VoxelizeOptions{
            .voxel_size = {0.5, 0.5, 0.5}, .feature = "random", .max_points_per_voxel = 3}));

TEST(Voxelize, RandomFeaturesDependOnTheSeedAlone) {
  const auto rows = random_numbers(2, 3 * 2000);
  const PointCloudView cloud = PointCloudView::packed(rows.data(), 2000);
  const VoxelizeOptions options{.voxel_size = {0.5, 0.5, 0.5}, .feature = "random", .seed = 1};
  VoxelizeOptions other = options;
  other.seed = 2;
  const int threads = default_threads();
  const Voxels first = voxelize(cloud, {}, options);
  set_default_threads(1);
  EXPECT_EQ(first.features, voxelize(cloud, {}, options).features);
  set_default_threads(threads);
  EXPECT_NE(first.features, voxelize(cloud, {}, other).features);
}

TEST(Voxelize, DropsNonFinitePoints) {
  const std::vector<float> rows = {NAN, 0, 0, 1, 1, 1, 0, INFINITY, 0};
  const Voxels voxels =
      voxelize(PointCloudView::packed(rows.data(), 3), {}, {.voxel_size = {1, 1, 1}}, 4);
  EXPECT_EQ(voxels.coordinates, (std::vector<Coordinate>{{4, 1, 1, 1}}));
  EXPECT_EQ(voxels.voxel_of_point, (std::vector<std::int32_t>{-1, 0, -1}));
}

TEST(Voxelize, NoPointsGiveNoVoxels) { EXPECT_EQ(voxelize({}, {}, {}).size(), 0u); }

TEST(Voxelize, RefusesBadOptionsChannelsAndExtents) {
  const std::vector<float> rows = {0, 0, 0, 5e7f, 0, 0};
  const PointCloudView cloud = PointCloudView::packed(rows.data(), 2);
  EXPECT_THROW(voxelize(cloud, {"ring"}, {}), InvalidArgument);
  EXPECT_THROW(voxelize(cloud, {}, {.feature = "median"}), ConfigError);
  EXPECT_THROW(voxelize(cloud, {}, {.voxel_size = {0, 1, 1}}), ConfigError);
  EXPECT_THROW(voxelize(cloud, {}, {.voxel_size = {1, 1, 1}}), InvalidArgument);
  EXPECT_THROW(voxelize(cloud, {}, {.voxel_size = {0.001, 1, 1}}), InvalidArgument);
}

}  // namespace
