#include "arbox/io/internal/pickle_text.h"

#include <charconv>

namespace arbox::io::internal {
namespace {

std::optional<char32_t> number_of(std::string_view digits, std::size_t count, int base) {
  if (digits.size() < count) return std::nullopt;
  std::uint32_t value = 0;
  const char* end = digits.data() + count;
  const auto [stop, error] = std::from_chars(digits.data(), end, value, base);
  if (stop != end || error != std::errc()) return std::nullopt;
  return value;
}

std::size_t octal_digits(std::string_view text) {
  std::size_t count = 0;
  while (count < 3 && count < text.size() && text[count] >= '0' && text[count] <= '7') ++count;
  return count;
}

}  // namespace

void append_utf8(std::string& text, char32_t code_point) {
  const auto tail = [&](int shift) {
    text += static_cast<char>(0x80 | ((code_point >> shift) & 0x3F));
  };
  if (code_point < 0x80) {
    text += static_cast<char>(code_point);
  } else if (code_point < 0x800) {
    text += static_cast<char>(0xC0 | (code_point >> 6));
    tail(0);
  } else if (code_point < 0x10000) {
    text += static_cast<char>(0xE0 | (code_point >> 12));
    tail(6);
    tail(0);
  } else {
    text += static_cast<char>(0xF0 | (code_point >> 18));
    tail(12);
    tail(6);
    tail(0);
  }
}

std::optional<std::string> unquoted_python_string(std::string_view line) {
  const char quote = line.empty() ? ' ' : line.front();
  if (line.size() < 2 || line.back() != quote || (quote != '\'' && quote != '"')) {
    return std::nullopt;
  }
  line = line.substr(1, line.size() - 2);
  constexpr std::string_view kLetters = "abfnrtv\\'\"", kMeant = "\a\b\f\n\r\t\v\\'\"";
  std::string text;
  while (!line.empty()) {
    const char c = line.front();
    line.remove_prefix(1);
    if (c != '\\') {
      text += c;
      continue;
    }
    if (line.empty()) return std::nullopt;
    const char escape = line.front();
    if (const std::size_t known = kLetters.find(escape); known != std::string_view::npos) {
      text += kMeant[known];
      line.remove_prefix(1);
    } else if (escape == 'x') {
      const auto value = number_of(line.substr(1), 2, 16);
      if (!value) return std::nullopt;
      text += static_cast<char>(*value);
      line.remove_prefix(3);
    } else if (const std::size_t digits = octal_digits(line); digits > 0) {
      text += static_cast<char>(*number_of(line, digits, 8));
      line.remove_prefix(digits);
    } else {
      text += '\\';
    }
  }
  return text;
}

std::optional<std::string> decode_raw_unicode_escape(std::string_view line) {
  std::string text;
  while (!line.empty()) {
    const char c = line.front();
    const std::size_t digits = line.starts_with("\\u") ? 4 : line.starts_with("\\U") ? 8 : 0;
    if (digits == 0) {
      append_utf8(text, static_cast<unsigned char>(c));
      line.remove_prefix(1);
      continue;
    }
    const auto value = number_of(line.substr(2), digits, 16);
    if (!value || *value > 0x10FFFF) return std::nullopt;
    append_utf8(text, *value);
    line.remove_prefix(2 + digits);
  }
  return text;
}

std::optional<std::string> to_latin1(std::string_view utf8) {
  std::string text;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    if (byte < 0x80) {
      text += utf8[i];
    } else if ((byte & 0xFE) == 0xC2 && i + 1 < utf8.size() && (utf8[i + 1] & 0xC0) == 0x80) {
      text += static_cast<char>(((byte & 3) << 6) | (utf8[++i] & 0x3F));
    } else {
      return std::nullopt;
    }
  }
  return text;
}

}  // namespace arbox::io::internal
