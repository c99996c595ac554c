#include <cstdlib>

#include "arbox/io/sunrgbd.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arbox::io;
  arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto calibration = parse_sunrgbd_calibration(bytes, "fuzz");
    calibration_of(projection_of(calibration));
  });
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto labels = parse_sunrgbd_labels(bytes, "fuzz");
    for (const auto& label : labels) to_object(label);
  });
}
