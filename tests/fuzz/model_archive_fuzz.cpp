#include <cstdlib>

#include "arbox/io/model_archive.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    using namespace arbox::io;
    const ModelArchive archive = parse_model_archive(bytes, "fuzz");
    if (parse_model_archive(encode_model_archive(archive), "again") != archive) std::abort();
  });
}
