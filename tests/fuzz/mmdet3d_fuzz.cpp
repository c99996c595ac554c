#include "arbox/io/mmdet3d.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    using namespace arbox::io;
    find_yaw_sense(read_mmdet3d_infos(parse_pickle(std::string(bytes), "fuzz")));
  });
}
