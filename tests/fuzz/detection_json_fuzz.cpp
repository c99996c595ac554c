#include <cstdlib>

#include "arbox/io/detection_json.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    using namespace arbox::io;
    const auto scans = parse_detections_json(bytes, "fuzz");
    const std::string text = format_detections_jsonl(scans);
    const auto again = parse_detections_json(text, "fuzz");
    if (again.size() != scans.size() || format_detections_jsonl(again).size() != text.size()) {
      std::abort();
    }
  });
}
