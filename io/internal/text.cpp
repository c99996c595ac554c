#include "arbox/io/internal/text.h"

#include <charconv>
#include <cmath>

#include "arbox/io/internal/parse.h"

namespace arbox::io::internal {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\v\f";

/// Whether every byte is part of an encoded letter: one lead byte and as many others as it says.
bool is_utf8(std::string_view text) {
  std::size_t expected = 0;
  for (const char letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    const bool continues = (code & 0xc0) == 0x80;
    if (continues != (expected > 0)) return false;
    if (continues) {
      --expected;
    } else if (code >= 0xc0) {
      expected = code >= 0xf0 ? 3 : (code >= 0xe0 ? 2 : 1);
    }
  }
  return expected == 0;
}

}  // namespace

void refuse(const TextPlace& place, const std::string& expected, const std::string& came) {
  std::string text(place.source);
  if (place.line > 0) text += ":" + std::to_string(place.line);
  throw FormatError(text + ": expected " + expected + ", got " + came);
}

std::string quoted_text(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string result = "'";
  const std::string_view shown = text.substr(0, kLongest);
  const bool letters = is_utf8(shown);
  for (const char letter : shown) {
    const auto code = static_cast<unsigned char>(letter);
    if (code < 0x20 || code == 0x7f || (code >= 0x80 && !letters)) {
      result += {'\\', 'x', kDigits[code >> 4], kDigits[code & 15]};
    } else {
      result += letter;
    }
  }
  return result + (text.size() > kLongest ? "...'" : "'");
}

LineReader::LineReader(std::string_view text, std::string_view source)
    : rest_(text), source_(source) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
}

bool LineReader::next() {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line_ = rest_.substr(0, end);
  rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  ++number_;
  return true;
}

bool LineReader::next_filled() {
  while (next()) {
    if (!trimmed(line_).empty()) return true;
  }
  return false;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kWhiteSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kWhiteSpace) - begin + 1);
}

std::vector<std::string_view> split_white_space(std::string_view line) {
  std::vector<std::string_view> fields;
  for (line = trimmed(line); !line.empty();) {
    const std::size_t end = line.find_first_of(kWhiteSpace);
    fields.push_back(line.substr(0, end));
    line = end == std::string_view::npos ? std::string_view() : trimmed(line.substr(end));
  }
  return fields;
}

bool is_number(std::string_view field) {
  double ignored = 0.0;
  return to_number(field, ignored);
}

double parse_number(std::string_view field, std::string_view name, const TextPlace& place) {
  double value = 0.0;
  if (!to_number(field, value) || !std::isfinite(value)) {
    refuse(place, "a finite number as " + std::string(name), quoted_text(field));
  }
  return value;
}

std::int64_t parse_integer(std::string_view field, std::string_view name, const TextPlace& place) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) {
    refuse(place, "a whole number as " + std::string(name), quoted_text(field));
  }
  return value;
}

void append_number(std::string& text, double number) {
  char buffer[40];
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::general, 17);
  text.append(buffer, result.ptr);
}

void append_fixed(std::string& text, double number, int decimals) {
  char buffer[400];
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::fixed, decimals);
  text.append(buffer, result.ptr);
}

}  // namespace arbox::io::internal
