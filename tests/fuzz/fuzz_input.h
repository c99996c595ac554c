#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "arbox/base/error.h"

namespace arbox::fuzz {

/// Calls parse(bytes). A parser may refuse with FormatError or InvalidArgument; every other
/// exception, crash, sanitizer report or excess of memory is a finding.
template <class Parse>
int run(const std::uint8_t* data, std::size_t size, Parse&& parse) {
  try {
    parse(std::string_view(reinterpret_cast<const char*>(data), size));
  } catch (const FormatError&) {
  } catch (const InvalidArgument&) {
  }
  return 0;
}

}  // namespace arbox::fuzz
