#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

/// \file
/// What the readers of point-cloud and array files share beyond internal/text.h: messages with byte
/// offsets and fast conversion of text to numbers of a given type.

namespace arbox::io::internal {

/// Throws FormatError "NAME: WHAT".
[[noreturn]] void fail(const std::string& name, const std::string& what);
/// Throws FormatError "NAME: byte N: WHAT"; the first byte is 0.
[[noreturn]] void fail_at_byte(const std::string& name, std::size_t byte, const std::string& what);

/// "a, b and c".
std::string listed(const std::vector<std::string>& words, const std::string& last = " and ");

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

std::string lower(std::string_view text);

/// The whole token as a number of type T; false if it is not one or does not fit. Floats may be
/// nan and inf in any case; magnitudes that T cannot hold become infinite or zero.
template <class T>
bool to_number(std::string_view token, T& value) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  if (stop != end || token.empty()) return false;
  if (error == std::errc()) return true;
  if constexpr (std::is_floating_point_v<T>) {
    if (error != std::errc::result_out_of_range) return false;
    const bool tiny = token.find("e-") != std::string_view::npos ||
                      token.find("E-") != std::string_view::npos || token.find("0.") <= 1;
    value = tiny ? T(0) : std::numeric_limits<T>::infinity();
    if (token.front() == '-') value = -value;
    return true;
  }
  return false;
}

}  // namespace arbox::io::internal
