#include <cstdlib>

#include "arbox/io/kitti_label.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto objects = arbox::io::parse_kitti_labels(bytes, "fuzz");
    const std::string text = arbox::io::format_kitti_labels(objects);
    if (objects.empty() != text.empty()) std::abort();
  });
}
