#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace arbox::io::internal {

/// What protocol 0 writes after S: a text in quotation marks with Python's escapes. Nothing if it
/// is not one.
std::optional<std::string> unquoted_python_string(std::string_view line);

/// What protocol 0 writes after V: Latin-1 characters and the escapes \uXXXX and \UXXXXXXXX, as
/// UTF-8. Nothing for broken escapes.
std::optional<std::string> decode_raw_unicode_escape(std::string_view line);

/// UTF-8 as Latin-1; nothing if a character is not in it.
std::optional<std::string> to_latin1(std::string_view utf8);

/// Appends a code point as UTF-8 (surrogates too, as Python does with "surrogatepass").
void append_utf8(std::string& text, char32_t code_point);

}  // namespace arbox::io::internal
