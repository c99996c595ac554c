#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "arbox/evaluation/kitti_files.h"
#include "arbox/evaluation/kitti_protocol.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_label.h"
#include "evaluation/kitti_cases.h"

/// \file
/// Scoring of a whole KITTI validation split, 3769 frames of made labels and results (about as many
/// objects as in the benchmark). The baseline reads and scores with one thread.

namespace {

namespace fs = std::filesystem;
using arbox::evaluation::KittiFrame;

constexpr int kFrames = 3769;

const std::vector<KittiFrame>& frames() {
  static const std::vector<KittiFrame> made = arbox::testing::random_frames(kFrames);
  return made;
}

/// The frames as files, removed when the program ends.
struct MadeFolders {
  fs::path root = fs::temp_directory_path() / ("arbox_benchmark_" + std::to_string(::getpid()));
  MadeFolders() {
    fs::create_directories(root / "labels");
    fs::create_directories(root / "results");
    for (std::size_t i = 0; i < frames().size(); ++i) {
      const std::string name = std::to_string(100000 + i) + ".txt";
      arbox::io::write_file(root / "labels" / name,
                            arbox::io::format_kitti_labels(frames()[i].labels));
      arbox::io::write_file(root / "results" / name,
                            arbox::io::format_kitti_results(frames()[i].predictions));
    }
  }
  ~MadeFolders() {
    std::error_code ignored;
    fs::remove_all(root, ignored);
  }
};

void read_and_score(benchmark::State& state) {
  static const MadeFolders folders;
  const auto threads = static_cast<int>(state.range(0));
  for (auto _ : state) {
    const auto read = arbox::evaluation::read_kitti_frames(
        folders.root / "labels", folders.root / "results", std::nullopt, threads);
    benchmark::DoNotOptimize(
        arbox::evaluation::evaluate_kitti(read.frames, {.threads = threads}).frames);
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
}

void score(benchmark::State& state) {
  const auto threads = static_cast<int>(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        arbox::evaluation::evaluate_kitti(frames(), {.threads = threads}).frames);
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
}

}  // namespace

BENCHMARK(score)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(read_and_score)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
