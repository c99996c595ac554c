#include <cstdlib>

#include "arbox/io/npy.h"
#include "point_cloud_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  arbox::fuzz::run_point_cloud(data, size, "npy");
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto array = arbox::io::parse_npy(bytes, "fuzz");
    if (array.values<double>().size() != array.size()) std::abort();
    static_cast<void>(array.values<std::int32_t>());
  });
}
