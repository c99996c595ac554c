#include "arbox/io/pickle.h"

#include <cstdlib>

#include "arbox/io/numpy_pickle.h"
#include "fuzz_input.h"

namespace {

using arbox::io::PickleKind;
using arbox::io::PickleValue;

/// Looks at everything that can be asked of a value, up to a number of values: those of a bomb are
/// without end.
void look_at(const PickleValue& value, int depth, int& left) {
  if (depth > 16 || --left < 0) return;
  const auto ask = [](auto&& question) {
    try {
      question();
    } catch (const arbox::FormatError&) {
    } catch (const arbox::InvalidArgument&) {
    }
  };
  ask([&] { static_cast<void>(value.numbers()); });
  ask([&] { static_cast<void>(value.bytes()); });
  ask([&] { static_cast<void>(numpy_array(value).values<double>()); });
  ask([&] { static_cast<void>(numpy_texts(value)); });
  ask([&] { static_cast<void>(numpy_objects(value)); });
  if (value.is(PickleKind::kDict) || value.is(PickleKind::kObject)) {
    static_cast<void>(value.find("k"));
    const std::size_t pairs = value.is(PickleKind::kDict) ? value.size() : 0;
    for (std::size_t i = 0; i < pairs; ++i) {
      look_at(value.key(i), depth + 1, left);
      look_at(value.value(i), depth + 1, left);
    }
  }
  if (value.is(PickleKind::kObject)) {
    look_at(value.callable(), depth + 1, left);
    look_at(value.arguments(), depth + 1, left);
    if (const auto state = value.state()) look_at(*state, depth + 1, left);
  }
  if (value.is(PickleKind::kList) || value.is(PickleKind::kTuple) || value.is(PickleKind::kSet)) {
    for (std::size_t i = 0; i < value.size(); ++i) look_at(value[i], depth + 1, left);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return arbox::fuzz::run(data, size, [](std::string_view bytes) {
    int left = 200;
    look_at(arbox::io::parse_pickle(std::string(bytes), "fuzz"), 0, left);
  });
}
