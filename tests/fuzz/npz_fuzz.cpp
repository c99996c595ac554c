#include "arbox/io/npz.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const arbox::io::NpzFile archive(std::string(bytes), "fuzz", 1 << 22);
    for (const auto& name : archive.names()) static_cast<void>(archive.read(name));
  });
}
