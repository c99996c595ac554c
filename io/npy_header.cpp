#include <algorithm>
#include <limits>
#include <optional>

#include "arbox/io/internal/npy_description.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/npy.h"

namespace arbox::io {
namespace {

using internal::fail;
using internal::NpyDescription;
using internal::quoted_text;

constexpr std::string_view kMagic = "\x93NUMPY";

// The header is a Python dictionary literal with three known keys.
class HeaderText {
 public:
  HeaderText(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  void parse(NpyDescription& header) {
    bool descr = false, order = false, shape = false;
    expect('{');
    while (!take('}')) {
      const std::string_view key = string();
      expect(':');
      if (key == "descr" && !descr) {
        parse_type(header);
        descr = true;
      } else if (key == "fortran_order" && !order) {
        header.fortran_order = boolean();
        order = true;
      } else if (key == "shape" && !shape) {
        parse_shape(header);
        shape = true;
      } else {
        refuse("expected the keys descr, fortran_order and shape once each, got " +
               quoted_text(key));
      }
      if (!take(',')) {
        expect('}');
        break;
      }
    }
    if (!descr || !order || !shape) {
      refuse("expected the keys descr, fortran_order and shape in " + quoted_text(text_));
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { fail(name_, "npy header: " + what); }

  void skip_blanks() {
    while (at_ < text_.size() && (internal::is_blank(text_[at_]) || text_[at_] == '\n')) ++at_;
  }

  bool take(char wanted) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }

  void expect(char wanted) {
    if (take(wanted)) return;
    refuse(std::string("expected '") + wanted + "' before " + quoted_text(text_.substr(at_)));
  }

  std::string_view string() {
    skip_blanks();
    const char quote = at_ < text_.size() ? text_[at_] : ' ';
    const std::size_t end =
        quote == '\'' || quote == '"' ? text_.find(quote, at_ + 1) : std::string_view::npos;
    if (end == std::string_view::npos) {
      refuse("expected a quoted word before " + quoted_text(text_.substr(at_)));
    }
    const std::string_view result = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return result;
  }

  std::string_view word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != ',' && text_[at_] != ')' && text_[at_] != '}' &&
           !internal::is_blank(text_[at_])) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  bool boolean() {
    const std::string_view value = word();
    if (value != "True" && value != "False") {
      refuse("expected True or False for fortran_order, got " + quoted_text(value));
    }
    return value == "True";
  }

  void parse_type(NpyDescription& header) {
    skip_blanks();
    if (at_ < text_.size() && text_[at_] == '[') {
      refuse("structured arrays are not read; expected one plain type, got " +
             quoted_text(text_.substr(at_)));
    }
    header.type = string();
  }

  void parse_shape(NpyDescription& header) {
    expect('(');
    while (!take(')')) {
      std::string_view size = word();
      if (size.ends_with('L')) size.remove_suffix(1);
      std::size_t value = 0;
      if (!internal::to_number(size, value)) {
        refuse("expected whole numbers in the shape, got " + quoted_text(size));
      }
      if (header.shape.size() == 32) refuse("expected at most 32 dimensions");
      header.shape.push_back(value);
      if (!take(',')) {
        expect(')');
        break;
      }
    }
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
};

std::string shape_text(const std::vector<std::size_t>& shape) {
  std::string result;
  for (const std::size_t size : shape) {
    result += result.empty() ? "(" : ", ";
    result += std::to_string(size);
  }
  return result.empty() ? "()" : result + ")";
}

}  // namespace

std::size_t NpyHeader::count() const {
  std::size_t product = 1;
  for (const std::size_t size : shape) product *= size;
  return product;
}

std::optional<NumberType> internal::number_type_of(std::string_view type) {
  if (type.size() != 3 || std::string_view("<>|=").find(type[0]) == std::string_view::npos) {
    return std::nullopt;
  }
  constexpr std::pair<std::string_view, NumberType> kTypes[] = {
      {"b1", NumberType::kBool},    {"?1", NumberType::kBool},    {"i1", NumberType::kInt8},
      {"u1", NumberType::kUint8},   {"i2", NumberType::kInt16},   {"u2", NumberType::kUint16},
      {"i4", NumberType::kInt32},   {"u4", NumberType::kUint32},  {"i8", NumberType::kInt64},
      {"u8", NumberType::kUint64},  {"f2", NumberType::kFloat16}, {"f4", NumberType::kFloat32},
      {"f8", NumberType::kFloat64},
  };
  for (const auto& [word, number] : kTypes) {
    if (word == type.substr(1)) return number;
  }
  return std::nullopt;
}

std::optional<std::size_t> internal::array_bytes(const std::vector<std::size_t>& shape,
                                                 std::size_t element_bytes) {
  std::size_t bytes = std::max<std::size_t>(element_bytes, 1);
  bool empty = element_bytes == 0;
  for (const std::size_t size : shape) {
    if (size > std::numeric_limits<std::ptrdiff_t>::max() / bytes) return std::nullopt;
    bytes *= std::max<std::size_t>(size, 1);
    empty |= size == 0;
  }
  return empty ? 0 : bytes;
}

void internal::require_array_bytes(const std::vector<std::size_t>& shape, std::size_t element_bytes,
                                   std::string_view type, std::size_t held,
                                   const std::string& name) {
  const auto wanted = array_bytes(shape, element_bytes);
  if (wanted && *wanted <= held) return;
  fail(name, "expected " + (wanted ? std::to_string(*wanted) : "more than 2^63") +
                 " bytes of data for shape " + shape_text(shape) + " of " + std::string(type) +
                 ", got " + std::to_string(held));
}

NpyDescription internal::parse_npy_description(std::string_view bytes, const std::string& name) {
  if (bytes.empty()) fail(name, "expected a npy file, got an empty file");
  if (!bytes.starts_with(kMagic)) {
    fail(name,
         "expected a npy file (first bytes \\x93NUMPY), got " + quoted_text(bytes.substr(0, 8)));
  }
  if (bytes.size() < 10) fail(name, "npy header: the file ends after its first bytes");
  const int version = static_cast<unsigned char>(bytes[6]);
  if (version < 1 || version > 3) {
    fail(name, "expected npy format version 1, 2 or 3, got " + std::to_string(version));
  }
  const std::size_t length_bytes = version == 1 ? 2 : 4;
  const std::size_t begin = 8 + length_bytes;
  std::size_t length = 0;
  for (std::size_t i = 0; i < length_bytes && 8 + i < bytes.size(); ++i) {
    length |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[8 + i])) << (8 * i);
  }
  if (begin > bytes.size() || length > bytes.size() - begin) {
    fail(name, "npy header: expected " + std::to_string(length) +
                   " bytes, but the file ends after " +
                   std::to_string(bytes.size() - std::min(begin, bytes.size())));
  }
  NpyDescription header;
  header.data_offset = begin + length;
  HeaderText(bytes.substr(begin, length), name).parse(header);
  return header;
}

NpyHeader parse_npy_header(std::string_view bytes, const std::string& name) {
  NpyDescription description = internal::parse_npy_description(bytes, name);
  const auto type = internal::number_type_of(description.type);
  if (!type) {
    fail(name, "npy header: expected a bool, integer or float type such as '<f4', got " +
                   quoted_text(description.type));
  }
  internal::require_array_bytes(description.shape, size_of(*type), name_of(*type),
                                bytes.size() - description.data_offset, name);
  return {.type = *type,
          .big_endian = description.type.front() == '>' && size_of(*type) > 1,
          .fortran_order = description.fortran_order,
          .shape = std::move(description.shape),
          .data_offset = description.data_offset};
}

}  // namespace arbox::io
