#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "arbox/sparse/convolution_map.h"
#include "arbox/sparse/coordinate_manager.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;

constexpr double kMega = 1024.0 * 1024.0;

/// A figure of /proc/self/status, bytes.
double status(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name + ":")) return 1024.0 * std::stod(line.substr(name.size() + 1));
  }
  return 0.0;
}

/// From here on the peak is that of now. False where the kernel does not allow it.
bool forget_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  return static_cast<bool>(file) && status("VmHWM") < status("VmRSS") + kMega;
}

/// How far `work` raises the process's memory beyond what it held before, bytes.
template <class Work>
double peak_of(const Work& work) {
  const double before = status("VmRSS");
  work();
  return status("VmHWM") - before;
}

// A floor of 320 x 320 voxels: 64 channels of all pairs would take 235 MB, the output takes 26.
TEST(ConvolutionMemory, IsBoundedBesideInputOutputWeightsAndMap) {
  if (!forget_peak()) GTEST_SKIP() << "/proc/self/clear_refs cannot be written";
  constexpr std::int32_t kSide = 320, kChannels = 64;
  std::vector<Coordinate> voxels;
  for (std::int32_t x = 0; x < kSide; ++x) {
    for (std::int32_t y = 0; y < kSide; ++y) voxels.push_back({0, x, y, 0});
  }
  CoordinateManager manager;
  const auto connection =
      manager.convolution(std::make_shared<const CoordinateSet>(voxels, Lattice{}), {});
  const MapRows rows{connection.inputs->sorted().rows, connection.outputs->sorted().rows};
  const auto count = voxels.size() * kChannels;
  std::vector<float> input(count, 0.5f), output(count, 0.25f);
  std::vector<float> weight(27 * kChannels * kChannels, 0.125f);
  const double all_pairs = static_cast<double>(connection.map->pairs()) * kChannels * sizeof(float);
  ASSERT_GT(all_pairs, 200 * kMega);

  forget_peak();
  EXPECT_LT(peak_of([&] {
              convolve(*connection.map, rows, input.data(), weight.data(), kChannels, kChannels,
                       output.data(), {}, 2);
            }),
            6 * kMega);
  forget_peak();
  EXPECT_LT(peak_of([&] {
              convolve_input_gradient(*connection.map, rows, output.data(), weight.data(),
                                      kChannels, kChannels, input.data(), 2);
            }),
            6 * kMega);
  forget_peak();
  EXPECT_LT(peak_of([&] {
              convolve_weight_gradient(*connection.map, rows, input.data(), output.data(),
                                       kChannels, kChannels, weight.data(), 2);
            }),
            (32 + 6) * kMega);
}

// The measure itself sees what is taken and given back.
TEST(ConvolutionMemory, ThePeakIsSeen) {
  if (!forget_peak()) GTEST_SKIP() << "/proc/self/clear_refs cannot be written";
  const double peak = peak_of([] {
    const std::vector<float> taken(16 << 20, 1.0f);
    EXPECT_EQ(taken[12345], 1.0f);
  });
  EXPECT_GT(peak, 60 * kMega);
}

}  // namespace
