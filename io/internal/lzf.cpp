#include "arbox/io/internal/lzf.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace arbox::io::internal {
namespace {

constexpr std::size_t kLongestLiteral = 32, kLongestMatch = 264, kFarthest = 8192;
constexpr std::size_t kShortestMatch = 3;

std::size_t byte_at(std::string_view data, std::size_t i) {
  return static_cast<unsigned char>(data[i]);
}

void copy_match(char* to, std::size_t distance, std::size_t length) {
  if (distance >= length) {
    std::memcpy(to, to - distance, length);
  } else if (distance == 1) {
    std::memset(to, to[-1], length);
  } else {
    // Source and target overlap on purpose: the copy repeats the last `distance` bytes.
    const char* from = to - distance;
    for (std::size_t i = 0; i < length; ++i) to[i] = from[i];
  }
}

void append_literals(std::string& stream, std::string_view literals) {
  while (!literals.empty()) {
    const std::size_t count = std::min(literals.size(), kLongestLiteral);
    stream += static_cast<char>(count - 1);
    stream += literals.substr(0, count);
    literals.remove_prefix(count);
  }
}

void append_match(std::string& stream, std::size_t distance, std::size_t length) {
  const std::size_t back = distance - 1, code = length - 2;
  stream += static_cast<char>((std::min<std::size_t>(code, 7) << 5) | (back >> 8));
  if (code >= 7) stream += static_cast<char>(code - 7);
  stream += static_cast<char>(back & 255);
}

}  // namespace

bool lzf_decompress(std::string_view stream, char* to, std::size_t size) {
  std::size_t in = 0, out = 0;
  while (in < stream.size()) {
    const std::size_t control = byte_at(stream, in++);
    if (control < kLongestLiteral) {
      const std::size_t count = control + 1;
      if (count > stream.size() - in || count > size - out) return false;
      std::memcpy(to + out, stream.data() + in, count);
      in += count;
      out += count;
      continue;
    }
    std::size_t length = (control >> 5) + 2;
    if (length == 9) {
      if (in >= stream.size()) return false;
      length += byte_at(stream, in++);
    }
    if (in >= stream.size()) return false;
    const std::size_t distance = ((control & 31) << 8) + byte_at(stream, in++) + 1;
    if (distance > out || length > size - out) return false;
    copy_match(to + out, distance, length);
    out += length;
  }
  return out == size;
}

std::string lzf_compress(std::string_view data) {
  constexpr int kHashBits = 15;
  constexpr std::size_t kNowhere = SIZE_MAX;
  std::vector<std::size_t> last(std::size_t{1} << kHashBits, kNowhere);
  const auto slot = [&](std::size_t i) -> std::size_t& {
    const std::size_t three =
        byte_at(data, i) | byte_at(data, i + 1) << 8 | byte_at(data, i + 2) << 16;
    return last[(three * 2654435761U & 0xffffffffU) >> (32 - kHashBits)];
  };
  std::string stream;
  std::size_t literals = 0, i = 0;
  while (i + kShortestMatch <= data.size()) {
    std::size_t& candidate = slot(i);
    const std::size_t from = candidate;
    candidate = i;
    if (from == kNowhere || i - from > kFarthest ||
        data.compare(from, kShortestMatch, data, i, kShortestMatch) != 0) {
      ++i;
      continue;
    }
    const std::size_t most = std::min(kLongestMatch, data.size() - i);
    std::size_t length = kShortestMatch;
    while (length < most && data[from + length] == data[i + length]) ++length;
    append_literals(stream, data.substr(literals, i - literals));
    append_match(stream, i - from, length);
    i += length;
    literals = i;
  }
  append_literals(stream, data.substr(literals));
  return stream;
}

}  // namespace arbox::io::internal
