#include <ATen/core/Tensor.h>
#include <ATen/ops/empty.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "arbox/base/random.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/sparse/voxel_tensor.h"
#include "arbox/sparse/voxelize.h"

namespace arbox::detectors::pv_rcnn {
namespace {

constexpr std::uint32_t kShuffle = 0x70766b31;
constexpr int kColumns = 4;

/// Points of one scan, rows x y z intensity.
struct ScanPoints {
  std::vector<float> rows;
  std::int64_t dropped = 0;
  std::size_t size() const { return rows.size() / kColumns; }
};

/// Brings intensities of any sensor's scale to 0..1, by the rule of io/point_cloud_file.h.
void scale_intensity(std::vector<float>& rows) {
  float largest = 0;
  for (std::size_t i = 3; i < rows.size(); i += kColumns) {
    if (!std::isfinite(rows[i])) rows[i] = 0;
    largest = std::max(largest, rows[i]);
  }
  if (largest <= 1) return;
  const float full = largest <= 255 ? 255.0f : largest <= 65535 ? 65535.0f : largest;
  for (std::size_t i = 3; i < rows.size(); i += kColumns) rows[i] /= full;
}

/// Whether point i of `count` is one of `most` that are spread evenly.
bool takes_part(std::uint64_t i, std::uint64_t count, std::uint64_t most) {
  return count <= most || i * most / count != (i + 1) * most / count;
}

ScanPoints cropped(const geometry::PointCloudView& cloud, const Options& options) {
  const VoxelOptions& voxels = options.voxels;
  const float low_x = static_cast<float>(voxels.low[0]),
              high_x = static_cast<float>(voxels.high[0]);
  const float low_y = static_cast<float>(voxels.low[1]),
              high_y = static_cast<float>(voxels.high[1]);
  const auto shift =
      static_cast<float>(options.sensor_height.value_or(options.trained_sensor_height) -
                         options.trained_sensor_height);
  const geometry::Channel* intensity = cloud.find("intensity");
  const auto most = static_cast<std::uint64_t>(voxels.max_points);
  ScanPoints result;
  result.rows.reserve(kColumns * std::min<std::size_t>(cloud.size(), most));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i);
    if (!p.allFinite()) {
      ++result.dropped;
      continue;
    }
    if (p.x() < low_x || p.x() > high_x || p.y() < low_y || p.y() > high_y) continue;
    if (!takes_part(i, cloud.size(), most)) continue;
    const float value =
        intensity == nullptr ? 0.0f : static_cast<float>(cloud.value(*intensity, i));
    result.rows.insert(result.rows.end(), {p.x(), p.y(), p.z() + shift, value});
  }
  scale_intensity(result.rows);
  return result;
}

void shuffle(std::vector<float>& rows, std::uint64_t seed, std::uint64_t scan) {
  const RandomStream stream(seed, scan, kShuffle);
  const std::size_t count = rows.size() / kColumns;
  for (std::size_t i = count; i > 1; --i) {
    const std::size_t j =
        stream.below(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i));
    std::swap_ranges(rows.begin() + kColumns * (i - 1), rows.begin() + kColumns * i,
                     rows.begin() + kColumns * j);
  }
}

sparse::VoxelizeOptions voxelize_options(const VoxelOptions& voxels, bool training) {
  sparse::VoxelizeOptions result;
  result.voxel_size = voxels.size;
  result.origin = voxels.low;
  result.grid = voxels.grid();
  result.max_points_per_voxel = voxels.max_points_per_voxel;
  result.max_voxels = training ? voxels.max_voxels_training : voxels.max_voxels;
  return result;
}

sparse::Lattice input_lattice(const Options& options) {
  const auto cells = options.voxels.grid();
  return {.stride = {1, 1, 1},
          .grid = sparse::Triple{cells[0], cells[1], cells[2] + options.backbone.height_margin}};
}

}  // namespace

PointBatch make_batch(std::span<const geometry::PointCloudView> clouds, const Options& options,
                      bool training, std::uint64_t seed, std::uint64_t first_scan) {
  std::vector<ScanPoints> scans;
  std::vector<sparse::Voxels> voxels;
  std::int64_t total = 0, dropped = 0;
  for (std::size_t scan = 0; scan < clouds.size(); ++scan) {
    scans.push_back(cropped(clouds[scan], options));
    if (training) shuffle(scans.back().rows, seed, first_scan + scan);
    const auto view = geometry::PointCloudView::packed(scans.back().rows.data(),
                                                       scans.back().size(), {"intensity"});
    voxels.push_back(sparse::voxelize(view, {"intensity"},
                                      voxelize_options(options.voxels, training),
                                      static_cast<std::int32_t>(scan)));
    total += static_cast<std::int64_t>(scans.back().size());
    dropped += scans.back().dropped;
  }
  at::Tensor points = at::empty({total, kColumns}, at::kFloat);
  float* to = points.data_ptr<float>();
  std::vector<std::int64_t> counts;
  for (const ScanPoints& scan : scans) {
    to = std::copy(scan.rows.begin(), scan.rows.end(), to);
    counts.push_back(static_cast<std::int64_t>(scan.size()));
  }
  return {std::move(points), std::move(counts),
          sparse::to_sparse_tensor(voxels, input_lattice(options)), dropped};
}

}  // namespace arbox::detectors::pv_rcnn
