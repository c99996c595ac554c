#include "scan_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/kitti_label.h"

namespace arbox::benchmarks {
namespace {

std::vector<int> ring_numbers(const geometry::PointCloudView& cloud) {
  std::vector<int> rings;
  double before = -1.0;
  int ring = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i);
    double azimuth = std::atan2(p.y(), p.x());
    if (azimuth < 0) azimuth += 2 * std::numbers::pi;
    if (azimuth < before - std::numbers::pi) ++ring;
    before = azimuth;
    rings.push_back(std::min(ring, 63));
  }
  return rings;
}

constexpr int kSectors = 36;

std::vector<std::vector<double>> ground_of(const geometry::PointCloudView& cloud) {
  std::vector<std::vector<double>> cells(20 * kSectors);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i);
    const auto row = static_cast<std::size_t>(std::hypot(p.x(), p.y()) / 2.5);
    const double turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi) + 0.5;
    const auto sector =
        std::min<std::size_t>(kSectors - 1, static_cast<std::size_t>(turn * kSectors));
    if (row < 20) cells[row * kSectors + sector].push_back(p.z());
  }
  std::vector<std::vector<double>> result(20);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (cells[cell].size() < 20) continue;
    result[cell / kSectors].push_back(quantile(cells[cell], 0.05));
  }
  return result;
}

ObjectFigures figures_of(const io::KittiObject& label, const geometry::Box& box,
                         const geometry::PointCloudView& cloud, const std::vector<int>& rings) {
  const geometry::Channel& channel = *cloud.find("intensity");
  std::vector<double> x, y, z;
  std::set<int> seen;
  double sum = 0, squares = 0, zeros = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d local =
        box.rotation.conjugate() * (cloud.position(i).cast<double>() - box.center);
    if ((local.cwiseAbs() - 0.5 * box.size).maxCoeff() > 0 || local.z() < 0.15 - 0.5 * box.size.z())
      continue;
    x.push_back(local.x());
    y.push_back(local.y());
    z.push_back(local.z());
    seen.insert(rings[i]);
    const double intensity = cloud.value(channel, i);
    sum += intensity;
    squares += intensity * intensity;
    zeros += intensity == 0;
  }
  ObjectFigures result{.type = label.type,
                       .distance = std::hypot(label.x, label.z),
                       .points = static_cast<double>(x.size()),
                       .occlusion = label.occlusion,
                       .truncation = label.truncation,
                       .features = {}};
  if (x.size() < 10) return result;
  const double n = result.points, mean = sum / n;
  const auto extent = [&](const std::vector<double>& v) {
    return quantile(v, 0.98) - quantile(v, 0.02);
  };
  const double span = *seen.rbegin() - *seen.begin() + 1;
  result.features.resize(9);
  result.features << std::log(n) + 2 * std::log(result.distance), extent(x) / box.size.x(),
      extent(y) / box.size.y(), extent(z) / box.size.z(), static_cast<double>(seen.size()) / span,
      n / static_cast<double>(seen.size()) * result.distance / 100, mean,
      std::sqrt(std::max(0.0, squares / n - mean * mean)), zeros / n;
  return result;
}

}  // namespace

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  const auto k = static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
  return values[k];
}

std::vector<ScanFigures> read_scans(const std::filesystem::path& root) {
  const io::KittiDataset dataset = io::KittiDataset::open(root);
  std::vector<ScanFigures> scans;
  for (const std::string& id : dataset.frames("training")) {
    const io::KittiFrame frame = dataset.load("training", id);
    const geometry::PointCloudView cloud = frame.cloud.view();
    const std::vector<int> rings = ring_numbers(cloud);
    const geometry::Channel& channel = *cloud.find("intensity");
    ScanFigures& scan = scans.emplace_back();
    scan.points = static_cast<double>(cloud.size());
    if (frame.image_size) {
      scan.in_image = static_cast<double>(
          io::points_in_image(cloud, frame.calibration, *frame.image_size).size());
    }
    scan.ground = ground_of(cloud);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3f p = cloud.position(i);
      const double intensity = cloud.value(channel, i);
      scan.range[std::min<std::size_t>(79, static_cast<std::size_t>(p.norm()))] += 1;
      scan.ring[static_cast<std::size_t>(rings[i])] += 1;
      scan.intensity[intensity < 0.005 ? 0 : 1 + static_cast<std::size_t>(intensity * 19.99)] += 1;
      const double turn = std::atan2(p.y(), p.x()) / std::numbers::pi;
      scan.azimuth[std::min<std::size_t>(71, static_cast<std::size_t>((turn + 1) * 36))] += 1;
    }
    for (const io::KittiObject& label : frame.labels) {
      if (!io::has_box(label)) continue;
      scan.objects.push_back(figures_of(label, io::to_box(label, frame.calibration), cloud, rings));
    }
  }
  return scans;
}

}  // namespace arbox::benchmarks
