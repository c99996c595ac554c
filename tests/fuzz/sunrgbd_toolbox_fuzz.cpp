#include "arbox/io/internal/mat_file.h"
#include "arbox/io/sunrgbd.h"
#include "fuzz_input.h"
#include "memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const arbox::fuzz::MemoryFile file(bytes);
    arbox::io::internal::read_mat_matrix(file.path(), "instance");
  });
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const arbox::fuzz::MemoryFile file(bytes);
    arbox::io::read_sunrgbd_toolbox(file.path());
  });
}
