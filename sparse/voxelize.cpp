#include "arbox/sparse/voxelize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/random.h"

namespace arbox::sparse {
namespace {

constexpr std::uint32_t kRandomPoint = 1;
constexpr float kFarthestCell = 1 << 29;

/// The voxel of each point that has one, and which points those are.
struct PlacedPoints {
  std::vector<Coordinate> coordinates;
  std::vector<std::int32_t> points;
};

PlacedPoints place(const geometry::PointCloudView& cloud, const VoxelizeOptions& options,
                   std::int32_t batch) {
  std::array<float, 3> origin, size;
  for (int axis = 0; axis < 3; ++axis) {
    origin[axis] = static_cast<float>(options.origin[axis]);
    size[axis] = static_cast<float>(options.voxel_size[axis]);
  }
  PlacedPoints result;
  result.coordinates.reserve(cloud.size());
  result.points.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f position = cloud.position(i);
    std::array<std::int32_t, 3> cell;
    bool inside = position.allFinite();
    for (int axis = 0; axis < 3 && inside; ++axis) {
      const float index = std::floor((position[axis] - origin[axis]) / size[axis]);
      const int cells = options.grid[axis];
      inside = cells == 0 || (index >= 0 && index < static_cast<float>(cells));
      if (inside && !(std::abs(index) < kFarthestCell)) {
        throw InvalidArgument("voxelize: point " + std::to_string(i) +
                              " is further than 2^29 voxels from the origin; crop the cloud");
      }
      if (inside) cell[axis] = static_cast<std::int32_t>(index);
    }
    if (!inside) continue;
    result.coordinates.push_back({batch, cell[0], cell[1], cell[2]});
    result.points.push_back(static_cast<std::int32_t>(i));
  }
  return result;
}

/// Runs of equal coordinates in sorted order, ordered by their first point.
struct Run {
  std::size_t begin, end;
  std::int32_t first_point;
};

std::vector<Run> runs_of(const SortedCoordinates& sorted, const PlacedPoints& placed) {
  std::vector<Run> runs;
  for (std::size_t begin = 0, end; begin < sorted.rows.size(); begin = end) {
    end = begin + 1;
    while (end < sorted.rows.size() && sorted.coordinates[end] == sorted.coordinates[begin]) ++end;
    runs.push_back({begin, end, placed.points[sorted.rows[begin]]});
  }
  std::sort(runs.begin(), runs.end(),
            [](const Run& a, const Run& b) { return a.first_point < b.first_point; });
  return runs;
}

class FeatureWriter {
 public:
  FeatureWriter(const geometry::PointCloudView& cloud, const std::vector<std::string>& channels,
                const VoxelizeOptions& options)
      : cloud_(cloud), options_(options) {
    for (const std::string& name : channels) {
      const geometry::Channel* channel = cloud.find(name);
      if (channel == nullptr) {
        throw InvalidArgument("voxelize: the cloud has no channel '" + name + "'");
      }
      channels_.push_back(*channel);
    }
    sums_.resize(3 + channels_.size());
  }

  std::int32_t columns() const { return static_cast<std::int32_t>(sums_.size()); }

  /// Appends the feature of a voxel whose counting points are points[0 .. count).
  template <class PointAt>
  void write(std::int32_t count, PointAt point_at, std::vector<float>& features) {
    std::fill(sums_.begin(), sums_.end(), 0.0);
    if (options_.feature == "mean") {
      for (std::int32_t i = 0; i < count; ++i) add(point_at(i));
      for (double& sum : sums_) sum /= count;
    } else if (options_.feature == "first") {
      add(point_at(0));
    } else {
      const RandomStream stream(options_.seed, static_cast<std::uint64_t>(point_at(0)),
                                kRandomPoint);
      add(point_at(static_cast<std::int32_t>(stream.below(0, static_cast<std::uint32_t>(count)))));
    }
    for (const double sum : sums_) features.push_back(static_cast<float>(sum));
  }

 private:
  void add(std::int32_t point) {
    const Eigen::Vector3f position = cloud_.position(point);
    for (int axis = 0; axis < 3; ++axis) sums_[axis] += position[axis];
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      sums_[3 + c] += cloud_.value(channels_[c], point);
    }
  }

  const geometry::PointCloudView& cloud_;
  const VoxelizeOptions& options_;
  std::vector<geometry::Channel> channels_;
  std::vector<double> sums_;
};

}  // namespace

Voxels voxelize(const geometry::PointCloudView& cloud, const std::vector<std::string>& channels,
                const VoxelizeOptions& options, std::int32_t batch) {
  validate_options(options, "voxelize");
  if (cloud.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw InvalidArgument("voxelize: more than 2^31 points; split the cloud");
  }
  FeatureWriter writer(cloud, channels, options);
  Voxels result;
  result.columns = writer.columns();
  result.voxel_of_point.assign(cloud.size(), -1);
  const PlacedPoints placed = place(cloud, options, batch);
  const SortedCoordinates sorted = sort_coordinates(placed.coordinates);
  std::vector<Run> runs = runs_of(sorted, placed);
  if (options.max_voxels > 0 && runs.size() > static_cast<std::size_t>(options.max_voxels)) {
    runs.resize(options.max_voxels);
  }
  result.features.reserve(runs.size() * result.columns);
  for (std::size_t v = 0; v < runs.size(); ++v) {
    const Run& run = runs[v];
    const auto points = static_cast<std::int32_t>(run.end - run.begin);
    const std::int32_t counting =
        options.max_points_per_voxel > 0 ? std::min(points, options.max_points_per_voxel) : points;
    const auto point_at = [&](std::int32_t i) { return placed.points[sorted.rows[run.begin + i]]; };
    for (std::int32_t i = 0; i < points; ++i) {
      result.voxel_of_point[point_at(i)] = static_cast<std::int32_t>(v);
    }
    result.coordinates.push_back(sorted.coordinates[run.begin]);
    result.counts.push_back(counting);
    writer.write(counting, point_at, result.features);
  }
  return result;
}

}  // namespace arbox::sparse
