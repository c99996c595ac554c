#include "arbox/io/torch_checkpoint.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const auto checkpoint = arbox::io::parse_torch_checkpoint(std::string(bytes), "fuzz");
    static_cast<void>(checkpoint.tensors(checkpoint.value()));
  });
}
