#include "arbox/io/internal/mat_image.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "arbox/base/error.h"
#include "arbox/io/internal/text.h"

namespace arbox::io::internal {
namespace {

constexpr std::size_t kMatHeader = 128;
constexpr std::size_t kTagBytes = 8;
constexpr std::size_t kLeastUnpacked = 4 << 20;
constexpr std::size_t kUnpackedRatio = 64;
constexpr std::size_t kMatPiece = 1 << 16;
constexpr int kDeepestMat = 16;
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 48;

// Types of data elements.
constexpr std::uint32_t kMatInt8 = 1, kMatInt32 = 5, kMatUint32 = 6, kMatMatrix = 14,
                        kMatCompressed = 15, kMatUtf8 = 16;
// Classes of arrays.
constexpr std::uint32_t kMatCell = 1, kMatStruct = 2, kMatChar = 4, kMatFirstNumeric = 6,
                        kMatLastNumeric = 15;

std::uint32_t word(std::string_view bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data(), sizeof(value));
  return value;
}

/// Bytes of one number of a type; 0 for what holds no numbers.
std::size_t width_of(std::uint32_t type) {
  constexpr std::array<std::size_t, 19> kWidths = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8,
                                                   0, 0, 8, 8, 0, 0, 1, 2, 4};
  return type < kWidths.size() ? kWidths[type] : 0;
}

struct MatElement {
  std::uint32_t type = 0;
  /// Four bytes or less within the tag itself.
  bool small = false;
  std::string_view data;
};

/// The elements of a part of a file, one after another.
class MatParts {
 public:
  MatParts(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}

  bool at_end() const { return rest_.empty(); }
  std::size_t left() const { return rest_.size(); }

  [[noreturn]] void refuse(const std::string& what) const {
    throw FormatError(name_ + ": expected " + what + " in a MATLAB 5.0 MAT-file");
  }

  MatElement next() {
    if (rest_.size() < kTagBytes) refuse("a whole element");
    const std::uint32_t first = word(rest_);
    MatElement element{.type = first & 0xFFFF, .small = first >> 16 != 0, .data = {}};
    std::size_t size = first >> 16, begin = 4, step = kTagBytes;
    if (element.small) {
      if (size > 4) refuse("a known type of element");
    } else {
      size = word(rest_.substr(4));
      begin = kTagBytes;
      // Compressed elements alone are not filled up to eight bytes.
      const std::size_t fill = element.type == kMatCompressed ? 0 : (8 - size % 8) % 8;
      step = kTagBytes + size + fill;
    }
    if (step > rest_.size()) {
      refuse("an element of " + std::to_string(size) + " bytes to lie in the " +
             std::to_string(rest_.size()) + " that are left");
    }
    element.data = rest_.substr(begin, size);
    rest_.remove_prefix(step);
    return element;
  }

  MatElement next(std::uint32_t type, const char* what) {
    const MatElement element = next();
    if (element.type != type) refuse(what);
    return element;
  }

 private:
  std::string_view rest_;
  const std::string& name_;
};

void check_array(std::string_view bytes, int depth, const std::string& name);

/// `count` arrays in a row; empty elements stand for empty arrays.
void check_arrays(MatParts& parts, std::uint64_t count, int depth, const std::string& name) {
  if (count > parts.left() / kTagBytes) parts.refuse("as many arrays as a size says");
  for (std::uint64_t i = 0; i < count; ++i) {
    const MatElement element = parts.next(kMatMatrix, "an array");
    if (element.small || element.data.size() % 8 != 0) parts.refuse("an array of whole words");
    if (!element.data.empty()) check_array(element.data, depth + 1, name);
  }
}

std::uint64_t read_count(MatParts& parts) {
  const MatElement sizes = parts.next(kMatInt32, "sizes of an array");
  const std::size_t rank = sizes.data.size() / 4;
  if (sizes.small || sizes.data.size() % 4 != 0 || rank < 2 || rank > 32) {
    parts.refuse("2 to 32 sizes of an array");
  }
  std::uint64_t count = 1;
  for (std::size_t i = 0; i < rank; ++i) {
    const std::uint32_t size = word(sizes.data.substr(4 * i));
    if (size > INT32_MAX) parts.refuse("sizes from 0");
    if (size != 0 && count > kMostElements / size) parts.refuse("sizes that memory can hold");
    count *= size;
  }
  return count;
}

void check_numbers(MatParts& parts, std::uint64_t count) {
  const MatElement numbers = parts.next();
  const std::size_t width = numbers.type < kMatUtf8 ? width_of(numbers.type) : 0;
  if (width == 0) parts.refuse("numbers of a known type");
  if (numbers.data.size() % width != 0 || numbers.data.size() / width != count) {
    parts.refuse(std::to_string(count) + " numbers, as the sizes say, not " +
                 std::to_string(numbers.data.size() / width));
  }
}

void check_text(MatParts& parts, std::uint64_t count) {
  const MatElement text = parts.next();
  const std::size_t width = width_of(text.type);
  if (width == 0 || (text.type > 4 && text.type < kMatUtf8)) parts.refuse("characters");
  const std::uint64_t units = text.data.size() / width;
  // A character of UTF-8 takes up to four bytes.
  const std::uint64_t most = text.type == kMatUtf8 ? 4 * count : count;
  if (text.data.size() % width != 0 || units < count || units > most) {
    parts.refuse(std::to_string(count) + " characters, as the sizes say");
  }
}

void check_struct(MatParts& parts, std::uint64_t count, int depth, const std::string& name) {
  const MatElement length = parts.next(kMatInt32, "the length of field names");
  if (!length.small || length.data.size() != 4) parts.refuse("the length of field names");
  const std::uint32_t size = word(length.data);
  const MatElement names = parts.next(kMatInt8, "field names");
  if (size == 0 || size > 64 || names.small || names.data.size() % size != 0) {
    parts.refuse("field names of the length that it tells");
  }
  const std::size_t fields = names.data.size() / size;
  for (std::size_t i = 0; i < fields; ++i) {
    if (names.data.substr(i * size, size).find('\0') == std::string_view::npos) {
      parts.refuse("field names that end");
    }
  }
  if (fields == 0 && count > 1) parts.refuse("structs with fields");
  // Each field takes a tag at least; that also keeps the product small.
  if (fields > 0 && count > parts.left() / kTagBytes / fields) {
    parts.refuse("as many structs as the sizes say");
  }
  check_arrays(parts, count * fields, depth, name);
}

void check_array(std::string_view bytes, int depth, const std::string& name) {
  MatParts parts(bytes, name);
  if (depth > kDeepestMat) parts.refuse("at most " + std::to_string(kDeepestMat) + " levels");
  const MatElement flags = parts.next(kMatUint32, "the flags of an array");
  if (flags.data.size() != 8) parts.refuse("the flags of an array");
  const std::uint32_t kind = word(flags.data) & 0xFF;
  const bool complex = (word(flags.data) & 0x800) != 0;
  const std::uint64_t count = read_count(parts);
  if (parts.next(kMatInt8, "a name").data.size() > 255) parts.refuse("a name of 255 bytes or less");
  if (kind >= kMatFirstNumeric && kind <= kMatLastNumeric) {
    check_numbers(parts, count);
    if (complex) check_numbers(parts, count);
  } else if (kind == kMatChar) {
    check_text(parts, count);
  } else if (kind == kMatCell) {
    check_arrays(parts, count, depth, name);
  } else if (kind == kMatStruct) {
    check_struct(parts, count, depth, name);
  } else {
    parts.refuse(
        "numbers, text, cells or structs; objects, functions and sparse matrices are not "
        "read. Expected no class " +
        std::to_string(kind));
  }
  if (!parts.at_end()) parts.refuse("nothing after the content of an array");
}

void inflate_to(std::string& image, std::string_view packed, std::size_t limit,
                const MatParts& parts) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw Error("zlib cannot be started");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  const std::size_t begin = image.size();
  int state = Z_OK;
  while (state == Z_OK && image.size() - begin <= limit) {
    const std::size_t from = image.size();
    image.resize(from + kMatPiece);
    stream.next_out = reinterpret_cast<Bytef*>(image.data() + from);
    stream.avail_out = kMatPiece;
    state = inflate(&stream, Z_NO_FLUSH);
    image.resize(image.size() - stream.avail_out);
    if (state == Z_OK && stream.avail_out != 0) state = Z_DATA_ERROR;  // The input is at its end.
  }
  inflateEnd(&stream);
  if (state == Z_OK) {
    parts.refuse("variables that unpack to " + std::to_string(limit) + " bytes or less");
  }
  if (state != Z_STREAM_END) parts.refuse("intact compressed data");
}

}  // namespace

std::string unpacked_mat(std::string_view file, const std::string& name) {
  if (file.size() < kMatHeader || !file.starts_with("MATLAB 5.0 MAT-file")) {
    throw FormatError(name +
                      ": expected a MATLAB 5.0 MAT-file (save it with -v7), got one that begins "
                      "with " +
                      quoted_text(file.substr(0, 16)));
  }
  MatParts parts(file.substr(kMatHeader), name);
  if (file[124] != 0 || file[125] != 1 || file.substr(126, 2) != "IM") {
    parts.refuse("version 0x0100 and little-endian numbers");
  }
  const std::size_t limit = std::max(kLeastUnpacked, kUnpackedRatio * file.size());
  std::string image(file.substr(0, kMatHeader));
  while (!parts.at_end()) {
    const MatElement element = parts.next();
    if (element.small || (element.type != kMatMatrix && element.type != kMatCompressed)) {
      parts.refuse("variables");
    }
    const std::size_t begin = image.size();
    if (element.type == kMatCompressed) {
      inflate_to(image, element.data, limit - std::min(limit, begin), parts);
    } else {
      image.append(element.data.data() - kTagBytes, kTagBytes + element.data.size());
    }
    MatParts unpacked(std::string_view(image).substr(begin), name);
    const MatElement variable = unpacked.next(kMatMatrix, "a variable");
    if (variable.small || variable.data.size() % 8 != 0 || !unpacked.at_end()) {
      parts.refuse("one variable an element");
    }
    check_array(variable.data, 0, name);
  }
  return image;
}

}  // namespace arbox::io::internal
