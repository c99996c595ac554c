#include "sparse_clouds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "arbox/sparse/voxelize.h"

namespace arbox::benchmarks {
namespace {

using sparse::Coordinate;

/// Points 1 cm apart, with 4 mm of noise, on rectangles.
class Surfaces {
 public:
  explicit Surfaces(std::uint32_t seed) : random_(seed) {}

  void rectangle(const std::array<double, 3>& from, const std::array<double, 3>& u,
                 const std::array<double, 3>& v) {
    std::normal_distribution<double> noise(0, 0.004);
    const auto length = [](const std::array<double, 3>& a) {
      return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    };
    const int nu = static_cast<int>(length(u) * 100), nv = static_cast<int>(length(v) * 100);
    for (int i = 0; i <= nu; ++i) {
      for (int j = 0; j <= nv; ++j) {
        for (int axis = 0; axis < 3; ++axis) {
          points.push_back(static_cast<float>(from[axis] + u[axis] * i / nu + v[axis] * j / nv +
                                              noise(random_)));
        }
      }
    }
  }

  void box(double x, double y, double yaw, double length, double width, double height) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const std::array<double, 3> u{c * length, s * length, 0}, v{-s * width, c * width, 0};
    const std::array<double, 3> up{0, 0, height};
    const std::array<double, 3> a{x - (u[0] + v[0]) / 2, y - (u[1] + v[1]) / 2, 0};
    const std::array<double, 3> b{x + (u[0] + v[0]) / 2, y + (u[1] + v[1]) / 2, 0};
    rectangle(a, u, up);
    rectangle(a, v, up);
    rectangle(b, {-u[0], -u[1], 0}, up);
    rectangle(b, {-v[0], -v[1], 0}, up);
    rectangle({a[0], a[1], height}, u, v);
  }

  std::vector<float> points;

 private:
  std::mt19937 random_;
};

std::vector<Coordinate> nearest(std::vector<Coordinate> voxels, std::size_t count,
                                const std::array<double, 3>& size) {
  const auto distance = [&size](const Coordinate& c) {
    return std::hypot(c.x * size[0], c.y * size[1], c.z * size[2]);
  };
  std::sort(voxels.begin(), voxels.end(),
            [&](const Coordinate& a, const Coordinate& b) { return distance(a) < distance(b); });
  voxels.resize(std::min(count, voxels.size()));
  std::shuffle(voxels.begin(), voxels.end(), std::mt19937(7));
  return voxels;
}

std::vector<Coordinate> voxels_of(const std::vector<float>& rows, std::size_t columns,
                                  const std::array<double, 3>& size, std::int32_t batch) {
  const geometry::PointCloudView cloud(rows.data(), rows.size() / columns, columns * sizeof(float));
  return sparse::voxelize(cloud, {}, {.voxel_size = size, .feature = "first"}, batch).coordinates;
}

std::vector<float> read_floats(const std::string& path) {
  const char* root = std::getenv("ARBOX_DATA");
  if (root == nullptr) return {};
  std::ifstream file(std::string(root) + "/" + path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<float> result(bytes.size() / sizeof(float));
  std::copy_n(bytes.data(), result.size() * sizeof(float), reinterpret_cast<char*>(result.data()));
  return result;
}

std::string kitti_path(int number) {
  std::string digits = std::to_string(number);
  digits.insert(0, 6 - digits.size(), '0');
  return "kitti/training/velodyne/" + digits + ".bin";
}

}  // namespace

std::vector<Coordinate> room_voxels(std::size_t count) {
  Surfaces surfaces(1);
  constexpr double kHalf = 0.01;  // planes through the middles of voxels
  surfaces.rectangle({0, 0, kHalf}, {6, 0, 0}, {0, 6, 0});
  surfaces.rectangle({kHalf, 0, 0}, {0, 6, 0}, {0, 0, 2.6});
  surfaces.rectangle({0, kHalf, 0}, {6, 0, 0}, {0, 0, 2.6});
  surfaces.rectangle({6 - kHalf, 0, 0}, {0, 6, 0}, {0, 0, 2.6});
  surfaces.rectangle({0, 6 - kHalf, 0}, {6, 0, 0}, {0, 0, 2.6});
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 25; ++i) {
    const double x = 0.5 + 5 * unit(random), y = 0.5 + 5 * unit(random), yaw = 6.28 * unit(random);
    const double length = 0.3 + 0.9 * unit(random), width = 0.3 + 0.6 * unit(random);
    surfaces.box(x, y, yaw, length, width, 0.3 + 0.9 * unit(random));
  }
  const std::array<double, 3> size{0.02, 0.02, 0.02};
  return nearest(voxels_of(surfaces.points, 3, size, 0), count, size);
}

std::vector<Coordinate> kitti_voxels(std::size_t count) {
  const std::array<double, 3> size{0.05, 0.05, 0.1};
  std::vector<Coordinate> all;
  for (int frame = 0; frame < 3 && all.size() < count; ++frame) {
    const std::vector<float> rows = read_floats(kitti_path(frame));
    if (rows.empty()) return {};
    const auto voxels = voxels_of(rows, 4, size, frame);
    all.insert(all.end(), voxels.begin(), voxels.end());
  }
  return nearest(std::move(all), count, size);
}

std::vector<float> kitti_points(int number, std::size_t count) {
  const std::vector<float> rows = read_floats(kitti_path(number));
  std::vector<float> points;
  for (std::size_t i = 0; i + 4 <= rows.size() && points.size() < 3 * count; i += 4) {
    if (rows[i] < std::abs(rows[i + 1])) continue;
    points.insert(points.end(), {rows[i], rows[i + 1], rows[i + 2]});
  }
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  while (points.size() < 3 * count) {
    const float range = 5 + 60 * unit(random) * unit(random), angle = 1.5f * unit(random) - 0.75f;
    points.insert(points.end(), {range * std::cos(angle), range * std::sin(angle),
                                 -1.7f + 2 * unit(random) * unit(random)});
  }
  return points;
}

std::vector<Coordinate> scannet_voxels() {
  const std::vector<float> rows = read_floats("scannet/points/scene0000_00.bin");
  if (rows.empty()) return {};
  return voxels_of(rows, 6, {0.01, 0.01, 0.01}, 0);
}

}  // namespace arbox::benchmarks
