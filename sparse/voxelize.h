#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/sparse/coordinates.h"

namespace arbox::sparse {

/// How points become voxels.
struct VoxelizeOptions {
  std::array<double, 3> voxel_size{0.01, 0.01, 0.01};
  /// Corner of voxel (0, 0, 0).
  std::array<double, 3> origin{0, 0, 0};
  /// Voxels along x, y, z beyond the origin; 0 means unbounded. Points outside are dropped.
  std::array<int, 3> grid{0, 0, 0};
  /// The feature of a voxel: the mean of its points, the first one or a random one.
  std::string feature = "mean";
  /// Points of a voxel that count, in the order of the cloud; 0 means all.
  int max_points_per_voxel = 0;
  /// Voxels at most, in the order in which the cloud first reaches them; 0 means all.
  int max_voxels = 0;
  std::uint64_t seed = 0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "voxel_size", &VoxelizeOptions::voxel_size,
        {.help = "Edges of a voxel along x, y, z", .unit = "m", .low = 1e-4, .high = 100});
    visitor.field("origin", &VoxelizeOptions::origin,
                  {.help = "Corner of voxel (0, 0, 0)", .unit = "m", .low = -1e6, .high = 1e6});
    visitor.field("grid", &VoxelizeOptions::grid,
                  {.help = "Voxels along x, y, z from the origin; 0 for unbounded",
                   .unit = "voxels",
                   .low = 0,
                   .high = 1 << 20});
    visitor.field("feature", &VoxelizeOptions::feature,
                  {.help = "Which features a voxel takes from its points",
                   .choices = {"mean", "first", "random"}});
    visitor.field("max_points_per_voxel", &VoxelizeOptions::max_points_per_voxel,
                  {.help = "Points of a voxel that count, first come first served; 0 for all",
                   .unit = "points",
                   .low = 0});
    visitor.field(
        "max_voxels", &VoxelizeOptions::max_voxels,
        {.help = "Voxels at most, first come first served; 0 for all", .unit = "voxels", .low = 0});
    visitor.field("seed", &VoxelizeOptions::seed, {.help = "Seed of feature: random"});
  }
};

/// Voxels in the order in which the cloud first reaches them.
struct Voxels {
  std::vector<Coordinate> coordinates;
  /// (size(), columns) float32: x, y, z in metres, then the asked channels.
  std::vector<float> features;
  std::int32_t columns = 3;
  /// Points of each voxel that count.
  std::vector<std::int32_t> counts;
  /// For each point of the cloud the row of its voxel, or -1 if it was dropped: non-finite, outside
  /// of the grid, or of a voxel refused by max_voxels. Points beyond max_points_per_voxel have
  /// their voxel here, but do not count.
  std::vector<std::int32_t> voxel_of_point;

  std::size_t size() const { return coordinates.size(); }
};

/// Voxel of a point: floor((position - origin) / voxel_size) in float32, as spconv and
/// MinkowskiEngine compute it; coordinates carry the batch number `batch`. Means are summed in
/// double in the order of the cloud. The result depends on cloud, options and batch alone, not on
/// threads; feature "random" draws by (seed, first point of the voxel). Finds voxels by a radix
/// sort of the points: O(N), 40 N bytes.
///
/// Throws ConfigError for options out of range, InvalidArgument for a channel that the cloud lacks
/// and for extents as sort_coordinates does. An empty cloud gives no voxels.
Voxels voxelize(const geometry::PointCloudView& cloud, const std::vector<std::string>& channels,
                const VoxelizeOptions& options, std::int32_t batch = 0);

}  // namespace arbox::sparse
