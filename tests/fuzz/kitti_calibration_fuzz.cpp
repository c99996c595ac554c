#include <cstdlib>

#include "arbox/io/kitti_calibration.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto calibration = arbox::io::parse_kitti_calibration(bytes, "fuzz");
    const std::string text = arbox::io::format_kitti_calibration(calibration);
    const auto again = arbox::io::parse_kitti_calibration(text, "fuzz");
    if (arbox::io::format_kitti_calibration(again) != text) std::abort();
    static_cast<void>(arbox::io::known_image_size(calibration));
    static_cast<void>(calibration.lidar_from_rect());
  });
}
