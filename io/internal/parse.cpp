#include "arbox/io/internal/parse.h"

#include <algorithm>
#include <cctype>

#include "arbox/base/error.h"

namespace arbox::io::internal {

void fail(const std::string& name, const std::string& what) {
  throw FormatError(name + ": " + what);
}

void fail_at_byte(const std::string& name, std::size_t byte, const std::string& what) {
  fail(name, "byte " + std::to_string(byte) + ": " + what);
}

std::string listed(const std::vector<std::string>& words, const std::string& last) {
  std::string result;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) result += i + 1 == words.size() ? last : ", ";
    result += words[i];
  }
  return result;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

}  // namespace arbox::io::internal
