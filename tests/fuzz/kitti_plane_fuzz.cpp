#include <cstdlib>

#include "arbox/io/kitti_calibration.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto plane = arbox::io::parse_kitti_plane(bytes, "fuzz");
    if (!(plane.normal.norm() < 1.0 + 1e-9) || plane.normal.y() > 0.0) std::abort();
  });
}
