#include <cstdlib>

#include "arbox/io/arbox_dataset.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arbox::io;
  arbox::fuzz::run(data, size, [](std::string_view bytes) { parse_camera_json(bytes, "fuzz"); });
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto description = parse_dataset_description(bytes, "fuzz");
    const auto again = parse_dataset_description(format_dataset_description(description), "fuzz");
    if (again.frame != description.frame) std::abort();
  });
}
