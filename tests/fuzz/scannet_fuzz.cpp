#include "arbox/io/scannet.h"
#include "fuzz_input.h"

// The first byte chooses the kind of file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arbox::io;
  if (size == 0) return 0;
  const std::uint8_t kind = data[0] & 3;
  return arbox::fuzz::run(data + 1, size - 1, [&](std::string_view bytes) {
    if (kind == 0) parse_scannet_segments(bytes, "fuzz");
    if (kind == 1) parse_scannet_aggregation(bytes, "fuzz");
    if (kind == 2) parse_scannet_alignment(bytes, "fuzz");
    if (kind == 3) parse_scannet_label_map(bytes, "fuzz");
  });
}
