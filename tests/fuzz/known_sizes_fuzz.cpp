#include <cstdlib>

#include "arbox/io/known_sizes.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const arbox::io::KnownSizeTable table = arbox::io::parse_known_sizes(bytes, "fuzz");
    if (table.sizes.empty() || table.lines.size() != table.sizes.size()) std::abort();
    for (const auto& [label, sizes] : table.sizes) {
      if (label.empty() || sizes.empty()) std::abort();
      for (const auto& known : sizes) {
        if (!(known.size.minCoeff() >= arbox::io::kLeastKnownExtent)) std::abort();
        if (!(known.size.maxCoeff() <= arbox::io::kMostKnownExtent)) std::abort();
      }
    }
  });
}
