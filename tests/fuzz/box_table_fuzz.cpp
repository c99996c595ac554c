#include <cstdlib>

#include "arbox/io/box_table.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    using namespace arbox::io;
    const BoxTable table =
        parse_box_table(bytes, "fuzz", {.object = true, .score = true, .class_name = true});
    const BoxTable again = parse_box_table(format_box_table(table), "fuzz");
    if (again.boxes.size() != table.boxes.size() || again.objects != table.objects ||
        again.scores != table.scores || again.classes != table.classes) {
      std::abort();
    }
    for (std::size_t i = 0; i < table.boxes.size(); ++i) {
      if (again.boxes[i].center != table.boxes[i].center) std::abort();
      if (again.boxes[i].size != table.boxes[i].size) std::abort();
    }
  });
}
