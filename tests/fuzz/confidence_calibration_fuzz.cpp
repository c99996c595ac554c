#include <cstdlib>

#include "arbox/evaluation/confidence_calibration.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    using namespace arbox::evaluation;
    const auto calibration = parse_confidence_calibration(bytes, "fuzz");
    const std::string text = to_json(calibration);
    if (to_json(parse_confidence_calibration(text, "fuzz")) != text) std::abort();
  });
}
