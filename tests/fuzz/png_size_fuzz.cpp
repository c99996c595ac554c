#include <cstdlib>

#include "arbox/io/image_size.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto image = arbox::io::parse_png_size(bytes, "fuzz");
    if (image.width < 1 || image.height < 1) std::abort();
  });
}
