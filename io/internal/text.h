#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/base/error.h"

/// \file
/// What the readers and writers of text files share: lines with numbers, fields, numbers that do
/// not depend on the locale, and one form of error message.

namespace arbox::io::internal {

/// One place in a text: the file's name and a line counted from 1 (0 for the file as a whole).
struct TextPlace {
  std::string_view source;
  std::size_t line = 0;
};

/// Throws FormatError "SOURCE:LINE: expected EXPECTED, got CAME".
[[noreturn]] void refuse(const TextPlace& place, const std::string& expected,
                         const std::string& came);

/// The text in quotation marks, unprintable bytes escaped, shortened if it is long.
std::string quoted_text(std::string_view text);

/// The words with `separator` between them.
template <class Words>
std::string joined(const Words& words, std::string_view separator) {
  std::string text;
  for (const auto& word : words) text.append(text.empty() ? "" : separator).append(word);
  return text;
}

/// Walks over the lines of a text; accepts \n and \r\n and skips a UTF-8 byte order mark.
class LineReader {
 public:
  LineReader(std::string_view text, std::string_view source);

  /// Moves to the next line; false at the end.
  bool next();
  /// Moves to the next line that holds more than white space; false at the end.
  bool next_filled();
  std::string_view line() const { return line_; }
  TextPlace place() const { return {source_, number_}; }
  /// The text after the line.
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  std::string_view line_;
  std::string_view source_;
  std::size_t number_ = 0;
};

std::string_view trimmed(std::string_view text);

/// Fields between runs of white space.
std::vector<std::string_view> split_white_space(std::string_view line);

/// True if the whole field is a number (nan and inf are).
bool is_number(std::string_view field);

/// The field as a finite number; refuses it naming `name` otherwise.
double parse_number(std::string_view field, std::string_view name, const TextPlace& place);

/// The field as a whole number; refuses it naming `name` otherwise.
std::int64_t parse_integer(std::string_view field, std::string_view name, const TextPlace& place);

/// Appends the number with 17 significant digits, which read back as the same double.
void append_number(std::string& text, double number);

/// Appends the number with `decimals` digits after the point.
void append_fixed(std::string& text, double number, int decimals);

}  // namespace arbox::io::internal
