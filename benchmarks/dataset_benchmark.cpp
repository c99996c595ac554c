// Loading a room of ScanNet and checking a folder of 10 000 scans, against plain reading of the
// same files. The files are made first, in a temporary folder; the folder of scans, 3 GB, stays in
// ARBOX_BENCHMARK_SCANS where that is set and is used again.
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arbox/base/parallel.h"
#include "arbox/base/random.h"
#include "arbox/io/dataset.h"
#include "arbox/io/dataset_check.h"
#include "arbox/io/file.h"

namespace {

namespace fs = std::filesystem;
using namespace arbox;

constexpr std::uint32_t kRoomPoints = 80'000;
constexpr int kRoomObjects = 60;
constexpr std::size_t kScans = 10'000;
constexpr std::uint32_t kScanPoints = 20'000;
constexpr int kScanObjects = 10;

/// A folder that goes away at the end of the program.
class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_(fs::temp_directory_path() / ("arbox_benchmark_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~TemporaryFolder() { fs::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

const fs::path& temporary() {
  static const TemporaryFolder folder;
  return folder.path();
}

/// A room with 60 objects, written in a layout.
io::LabeledScene made_room() {
  const RandomStream random(1, 0, 0);
  io::LabeledScene scene{.name = "scene0000_00", .source = {}, .frame = io::SceneFrame::kRoom};
  scene.cloud.channels = {"r", "g", "b"};
  for (std::uint32_t i = 0; i < kRoomPoints; ++i) {
    const auto object = static_cast<int>(i / (kRoomPoints / 120));
    const Eigen::Vector3d corner(object % 10, object / 10 % 6, object / 60);
    for (int c = 0; c < 3; ++c) {
      const double place = random.uniform(3 * i + static_cast<std::uint32_t>(c), 0.0, 0.8);
      scene.cloud.values.push_back(static_cast<float>(corner[c] + place));
    }
    scene.cloud.values.insert(scene.cloud.values.end(), {0.2F, 0.4F, 0.6F});
    scene.point_objects.push_back(object < kRoomObjects ? object : -1);
  }
  for (int object = 0; object < kRoomObjects; ++object) {
    io::LabeledObject one;
    one.label = "chair";
    one.box.center = Eigen::Vector3d(object % 10 + 0.4, object / 10 % 6 + 0.4, 0.4);
    one.box.size = Eigen::Vector3d::Constant(0.8);
    scene.objects.push_back(one);
  }
  return scene;
}

fs::path room(const std::string& layout) {
  const fs::path root = temporary() / layout;
  if (fs::exists(root)) return root;
  const auto writer = io::create_dataset(root, layout, io::SceneFrame::kRoom);
  writer->add("train", made_room());
  writer->finish();
  return root;
}

void load_room(benchmark::State& state, const std::string& layout) {
  const auto dataset = io::open_dataset(room(layout));
  for (auto _ : state) {
    const auto scene = dataset->load("train", "scene0000_00");
    if (scene.cloud.size() != kRoomPoints || scene.objects.size() != kRoomObjects) {
      state.SkipWithError("expected the room that was written");
    }
  }
}
BENCHMARK_CAPTURE(load_room, raw_release, std::string("scannet"))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(load_room, votenet_npy, std::string("scannet-votenet"))
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(load_room, mmdetection3d_bin, std::string("scannet-mmdet3d"))
    ->Unit(benchmark::kMillisecond);

/// The baseline: the raw release's files read into memory, and their JSON into trees.
void parse_room_files(benchmark::State& state) {
  const std::string base = (room("scannet") / "scans/scene0000_00/scene0000_00").string();
  for (auto _ : state) {
    benchmark::DoNotOptimize(io::read_file(base + "_vh_clean_2.ply"));
    benchmark::DoNotOptimize(
        nlohmann::json::parse(io::read_file(base + "_vh_clean_2.0.010000.segs.json")));
    benchmark::DoNotOptimize(nlohmann::json::parse(io::read_file(base + ".aggregation.json")));
  }
}
BENCHMARK(parse_room_files)->Unit(benchmark::kMillisecond);

io::LabeledScene made_scan() {
  const RandomStream random(2, 0, 0);
  io::LabeledScene scene{.name = "000000"};
  scene.cloud.channels = {"intensity"};
  for (std::uint32_t i = 0; i < kScanPoints; ++i) {
    for (std::uint32_t c = 0; c < 2; ++c) {
      scene.cloud.values.push_back(static_cast<float>(random.uniform(3 * i + c, -60, 60)));
    }
    scene.cloud.values.push_back(static_cast<float>(random.uniform(3 * i + 2, -2, 1)));
    scene.cloud.values.push_back(0.5F);
  }
  for (int b = 0; b < kScanObjects; ++b) {
    io::LabeledObject car;
    car.label = "Car";
    car.box = geometry::make_yaw_box({5.0 * b + 5.0, 3, -1}, {4, 2, 1.5}, b);
    scene.objects.push_back(car);
  }
  return scene;
}

std::string scan_name(std::size_t i) {
  const std::string digits = std::to_string(i);
  return std::string(6 - digits.size(), '0') + digits;
}

/// 10 000 scans in KITTI's layout.
const fs::path& scans() {
  static const fs::path root = [] {
    const char* kept = std::getenv("ARBOX_BENCHMARK_SCANS");
    const fs::path folder = kept != nullptr ? fs::path(kept) : temporary() / "scans";
    const fs::path list = folder / "ImageSets" / "train.txt";
    if (fs::exists(folder / "ImageSets" / "made.txt")) return folder;
    const auto writer = io::create_dataset(folder, "kitti");
    writer->add("train", made_scan());
    writer->finish();
    std::string names = scan_name(0) + "\n";
    for (std::size_t i = 1; i < kScans; ++i) {
      for (const std::string part : {"velodyne/#.bin", "label_2/#.txt", "calib/#.txt"}) {
        const auto named = [&](std::size_t number) {
          std::string file = part;
          return folder / "training" / file.replace(file.find('#'), 1, scan_name(number));
        };
        fs::copy_file(named(0), named(i));
      }
      names += scan_name(i) + "\n";
    }
    io::write_file(list, names);
    io::write_file(folder / "ImageSets" / "made.txt", names);
    ::sync();
    return folder;
  }();
  return root;
}

std::vector<fs::path> files_of(std::size_t scan) {
  const std::string name = scan_name(scan);
  const fs::path base = scans() / "training";
  return {base / "velodyne" / (name + ".bin"), base / "label_2" / (name + ".txt"),
          base / "calib" / (name + ".txt")};
}

int open_to_read(const fs::path& file) { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC); }

/// The baseline: every byte of the files, in the checker's order, into one buffer a thread that
/// stays in the cache.
std::uint64_t read_all_scans(int threads) {
  std::atomic<std::uint64_t> bytes = 0;
  parallel_for(kScans, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    thread_local std::vector<char> buffer(std::size_t{1} << 19);
    for (std::int64_t i = begin; i < end; ++i) {
      for (const fs::path& file : files_of(static_cast<std::size_t>(i))) {
        const int descriptor = open_to_read(file);
        ssize_t got = 0;
        while ((got = ::read(descriptor, buffer.data(), buffer.size())) > 0) {
          bytes += static_cast<std::uint64_t>(got);
        }
        ::close(descriptor);
      }
    }
  });
  return bytes;
}

/// Has the files read from the disk next time.
void forget_scans() {
  for (std::size_t i = 0; i < kScans; ++i) {
    for (const fs::path& file : files_of(i)) {
      const int descriptor = open_to_read(file);
      if (descriptor < 0) continue;
      ::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
      ::close(descriptor);
    }
  }
}

void prepare(bool from_disk) {
  forget_scans();
  if (!from_disk) read_all_scans(default_threads());
}

void count_scans(benchmark::State& state) {
  const auto scans_done = state.iterations() * static_cast<std::int64_t>(kScans);
  state.SetItemsProcessed(scans_done);
  state.SetBytesProcessed(scans_done * kScanPoints * 16);
}

void check_scans(benchmark::State& state) {
  const auto dataset = io::open_dataset(scans());
  for (auto _ : state) {
    state.PauseTiming();
    prepare(state.range(0) != 0);
    state.ResumeTiming();
    if (io::check_dataset(*dataset, "train").objects != kScanObjects * kScans) {
      state.SkipWithError("expected 10 objects a scan");
    }
  }
  count_scans(state);
}

void read_scans(benchmark::State& state) {
  scans();
  for (auto _ : state) {
    state.PauseTiming();
    prepare(state.range(0) != 0);
    state.ResumeTiming();
    if (read_all_scans(static_cast<int>(state.range(1))) < kScans * kScanPoints * 16) {
      state.SkipWithError("expected all bytes of the scans");
    }
  }
  count_scans(state);
}

void once(benchmark::internal::Benchmark* benchmark) {
  benchmark->Iterations(1)->Unit(benchmark::kMillisecond)->UseRealTime();
}

// In turns, since a disk's speed changes from one moment to the next.
const int kReaders = default_threads(), kCheckers = 4 * default_threads();
BENCHMARK(read_scans)->ArgNames({"from_disk", "threads"})->Args({1, kReaders})->Apply(once);
BENCHMARK(check_scans)->ArgName("from_disk")->Arg(1)->Apply(once);
BENCHMARK(read_scans)->ArgNames({"from_disk", "threads"})->Args({1, kCheckers})->Apply(once);
BENCHMARK(check_scans)->ArgName("from_disk")->Arg(0)->Apply(once);
BENCHMARK(read_scans)->ArgNames({"from_disk", "threads"})->Args({0, kReaders})->Apply(once);

}  // namespace
