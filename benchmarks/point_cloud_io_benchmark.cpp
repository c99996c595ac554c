// Reading point clouds of 120 000 points against PCL's loaders, the same files in the same run.
// Every program writes its files to a temporary folder first; the page cache is warm.
#include <benchmark/benchmark.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "arbox/io/point_cloud_file.h"

namespace {

namespace fs = std::filesystem;
using arbox::io::PointCloudFormat;

constexpr int kPoints = 120'000;

// A scan-like cloud: 64 rings around the sensor.
arbox::geometry::PointCloud make_scan() {
  arbox::geometry::PointCloud scan{.channels = {"intensity"}, .values = {}};
  for (int i = 0; i < kPoints; ++i) {
    const auto angle = static_cast<float>(i % 1875) * 0.00335F;
    const float range = 5.0F + 60.0F * std::fabs(std::sin(static_cast<float>(i) * 0.37F));
    const float height = static_cast<float>(i / 1875) * 0.04F - 1.7F;
    scan.values.insert(scan.values.end(), {range * std::cos(angle), range * std::sin(angle), height,
                                           static_cast<float>(i % 100) / 100.0F});
  }
  return scan;
}

class Files {
 public:
  Files() : folder_(fs::temp_directory_path() / ("arbox_io_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    const auto scan = make_scan();
    for (const char* encoding : {"ascii", "binary", "binary_compressed"}) {
      arbox::io::write_point_cloud(path(std::string(encoding) + ".pcd"), scan.view(),
                                   {.encoding = encoding});
    }
    for (const char* encoding : {"ascii", "binary"}) {
      arbox::io::write_point_cloud(path(std::string(encoding) + ".ply"), scan.view(),
                                   {.encoding = encoding});
    }
    for (const char* name : {"scan.bin", "scan.npy", "scan.npz", "scan.csv"}) {
      arbox::io::write_point_cloud(path(name), scan.view());
    }
  }
  ~Files() { fs::remove_all(folder_); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  fs::path path(const std::string& name) const { return folder_ / name; }

 private:
  fs::path folder_;
};

const Files& files() {
  static const Files kFiles;
  return kFiles;
}

void count(benchmark::State& state, const fs::path& path, std::size_t points) {
  if (points != kPoints) state.SkipWithError("wrong number of points");
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(fs::file_size(path)));
}

void arbox_reads(benchmark::State& state, const char* name) {
  const fs::path path = files().path(name);
  std::size_t points = 0;
  for (auto _ : state) {
    points = arbox::io::read_point_cloud(path).points.size();
  }
  count(state, path, points);
}

void pcl_reads(benchmark::State& state, const char* name) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  const fs::path path = files().path(name);
  std::size_t points = 0;
  for (auto _ : state) {
    pcl::PointCloud<pcl::PointXYZI> cloud;
    if (path.extension() == ".ply") {
      pcl::io::loadPLYFile(path.string(), cloud);
    } else {
      pcl::io::loadPCDFile(path.string(), cloud);
    }
    points = cloud.size();
  }
  count(state, path, points);
}

// What reading cannot beat: the same bytes copied into memory by one read.
void plain_read(benchmark::State& state, const char* name) {
  const fs::path path = files().path(name);
  for (auto _ : state) {
    std::string content(fs::file_size(path), '\0');
    std::ifstream(path, std::ios::binary)
        .read(content.data(), static_cast<std::streamsize>(content.size()));
    benchmark::DoNotOptimize(content.data());
  }
  count(state, path, kPoints);
}

#define ARBOX_AND_PCL(name)                                                                \
  BENCHMARK_CAPTURE(arbox_reads, name, name)->Unit(benchmark::kMillisecond)->MinTime(0.3); \
  BENCHMARK_CAPTURE(pcl_reads, name, name)->Unit(benchmark::kMillisecond)->MinTime(0.3)
ARBOX_AND_PCL("binary.pcd");
ARBOX_AND_PCL("binary_compressed.pcd");
ARBOX_AND_PCL("ascii.pcd");
ARBOX_AND_PCL("binary.ply");
ARBOX_AND_PCL("ascii.ply");
#undef ARBOX_AND_PCL
BENCHMARK_CAPTURE(arbox_reads, "scan.bin", "scan.bin")->Unit(benchmark::kMillisecond)->MinTime(0.3);
BENCHMARK_CAPTURE(plain_read, "scan.bin", "scan.bin")->Unit(benchmark::kMillisecond)->MinTime(0.3);
BENCHMARK_CAPTURE(arbox_reads, "scan.npy", "scan.npy")->Unit(benchmark::kMillisecond)->MinTime(0.3);
BENCHMARK_CAPTURE(arbox_reads, "scan.npz", "scan.npz")->Unit(benchmark::kMillisecond)->MinTime(0.3);
BENCHMARK_CAPTURE(arbox_reads, "scan.csv", "scan.csv")->Unit(benchmark::kMillisecond)->MinTime(0.3);

}  // namespace
