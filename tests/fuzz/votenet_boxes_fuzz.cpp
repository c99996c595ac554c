#include <cstdlib>

#include "arbox/evaluation/indoor_files.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const bool with_scores : {false, true}) {
    arbox::fuzz::run(data, size, [&](std::string_view bytes) {
      for (const auto& box : arbox::evaluation::parse_votenet_boxes(bytes, "fuzz", with_scores)) {
        if (!(box.box.size.array() > 0.0).all() || !box.box.center.allFinite()) std::abort();
      }
    });
  }
  return 0;
}
