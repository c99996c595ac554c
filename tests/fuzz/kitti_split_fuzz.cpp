#include <cstdlib>

#include "arbox/io/kitti_dataset.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    for (const auto& name : arbox::io::parse_kitti_split(bytes, "fuzz")) {
      if (name.empty() || name.find_first_of("/\\ \n") != std::string::npos) std::abort();
    }
  });
}
