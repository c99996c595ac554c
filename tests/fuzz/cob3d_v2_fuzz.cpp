#include "arbox/io/cob3d.h"
#include "fuzz_input.h"
#include "memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const arbox::fuzz::MemoryFile file(bytes);
    arbox::io::read_cob3d_v2_scene(file.path());
  });
}
