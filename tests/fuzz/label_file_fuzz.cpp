#include <cstdlib>

#include "arbox/io/label_file.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace arbox::io;
  arbox::fuzz::run(data, size, [](std::string_view bytes) { parse_label_text(bytes, "fuzz"); });
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    const LabelFile file = parse_label_json(bytes, "fuzz");
    const LabelFile again =
        parse_label_json(format_label_json(file.objects, SceneFrame::kRoom), "fuzz");
    if (again.objects.size() != file.objects.size()) std::abort();
  });
}
