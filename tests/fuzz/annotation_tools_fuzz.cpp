#include "arbox/io/annotation_tools.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arbox::io;
  arbox::fuzz::run(data, size, [](std::string_view bytes) { parse_cvat_tracklets(bytes, "fuzz"); });
  arbox::fuzz::run(data, size,
                   [](std::string_view bytes) { parse_labelcloud_kitti(bytes, "fuzz"); });
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    parse_labelcloud_json(bytes, "fuzz", AngleUnit::kDegrees);
  });
}
