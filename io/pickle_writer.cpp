#include "arbox/io/pickle_writer.h"

#include <algorithm>
#include <bit>
#include <type_traits>

#include "arbox/base/error.h"
#include "arbox/io/internal/npy_description.h"
#include "arbox/io/internal/pickle_text.h"

namespace arbox::io {
namespace {

using namespace std::string_view_literals;

constexpr char32_t kReplacement = 0xFFFD;
constexpr std::string_view kReconstruct =
    "cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\0\x85"
    "C\1b\x87R"sv;

template <class T>
std::string little_endian(T value, int size) {
  std::string bytes;
  for (int i = 0; i < size; ++i) bytes += static_cast<char>((value >> (8 * i)) & 255);
  return bytes;
}

/// The code points of a UTF-8 text, U+FFFD for each byte that is in none.
std::u32string code_points(std::string_view utf8) {
  std::u32string points;
  for (std::size_t i = 0; i < utf8.size();) {
    const auto lead = static_cast<unsigned char>(utf8[i]);
    const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    char32_t point = length == 1 ? lead : lead & (0x7F >> length);
    bool whole = (lead < 0x80 || lead >= 0xC2) && lead < 0xF5 && i + length <= utf8.size();
    for (std::size_t k = 1; whole && k < length; ++k) {
      const auto next = static_cast<unsigned char>(utf8[i + k]);
      whole = (next & 0xC0) == 0x80;
      point = (point << 6) | (next & 0x3F);
    }
    constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    whole =
        whole && point >= kLeast[length] && point <= 0x10FFFF && (point < 0xD800 || point > 0xDFFF);
    points += whole ? point : kReplacement;
    i += whole ? length : 1;
  }
  return points;
}

std::string valid_utf8(std::string_view text) {
  std::string result;
  for (const char32_t point : code_points(text)) internal::append_utf8(result, point);
  return result;
}

std::string_view numpy_word(NumberType type) {
  constexpr std::string_view kWords[] = {"b1", "i1", "u1", "i2", "u2", "i4",
                                         "u4", "i8", "u8", "f2", "f4", "f8"};
  return kWords[static_cast<int>(type)];
}

}  // namespace

PickleWriter::PickleWriter() : bytes_("\x80\4"), open_{{Kind::kPickle}} {}

void PickleWriter::count() {
  if (open_.empty()) throw InvalidArgument("PickleWriter: a value after the end");
  ++open_.back().values;
}

void PickleWriter::put_length(std::uint64_t length, char small, char large) {
  bytes_ += length <= UINT32_MAX ? small : large;
  bytes_ += little_endian(length, length <= UINT32_MAX ? 4 : 8);
}

void PickleWriter::put_integer(std::int64_t value) {
  if (value >= 0 && value < 256) {
    bytes_ += 'K';
    bytes_ += static_cast<char>(value);
  } else if (value >= INT32_MIN && value <= INT32_MAX) {
    bytes_ += 'J';
    bytes_ += little_endian(value, 4);
  } else {
    bytes_ += "\x8a\x08";
    bytes_ += little_endian(value, 8);
  }
}

void PickleWriter::put_text(std::string_view value) {
  put_length(value.size(), 'X', '\x8d');
  put(value);
}

void PickleWriter::put_bytes(std::string_view value) {
  put_length(value.size(), 'B', '\x8e');
  put(value);
}

void PickleWriter::none() {
  count();
  put("N");
}

void PickleWriter::boolean(bool value) {
  count();
  put(value ? "\x88" : "\x89");
}

void PickleWriter::integer(std::int64_t value) {
  count();
  put_integer(value);
}

void PickleWriter::number(double value) {
  count();
  std::string bytes = little_endian(std::bit_cast<std::uint64_t>(value), 8);
  std::reverse(bytes.begin(), bytes.end());
  put("G");
  put(bytes);
}

void PickleWriter::text(std::string_view value) {
  count();
  put_text(valid_utf8(value));
}

void PickleWriter::bytes(std::string_view value) {
  count();
  put_bytes(value);
}

void PickleWriter::begin(Kind kind, std::string_view code) {
  count();
  open_.push_back({kind});
  put(code);
}

void PickleWriter::begin_list() { begin(Kind::kList, "]("); }
void PickleWriter::begin_dict() { begin(Kind::kDict, "}("); }

void PickleWriter::begin_object_array() {
  begin(Kind::kObject, "");
  begin_array({});
  put_type("O8", '|', -1, -1, 63);
  put("\x89](");
}

void PickleWriter::end() {
  if (open_.size() < 2) throw InvalidArgument("PickleWriter: nothing to end");
  const Open last = open_.back();
  open_.pop_back();
  if (last.kind == Kind::kDict && last.values % 2 != 0) {
    throw InvalidArgument("PickleWriter: a dictionary ends with a key that has no value");
  }
  if (last.kind == Kind::kObject && last.values != 1) {
    throw InvalidArgument("PickleWriter: an array of one object got " +
                          std::to_string(last.values));
  }
  put(last.kind == Kind::kDict ? "u" : last.kind == Kind::kList ? "e" : "etb");
}

void PickleWriter::numbers(std::span<const double> values) {
  begin_list();
  for (const double value : values) number(value);
  end();
}

void PickleWriter::rows(std::span<const double> values, std::size_t columns) {
  begin_list();
  for (std::size_t i = 0; i + columns <= values.size() && columns > 0; i += columns) {
    numbers(values.subspan(i, columns));
  }
  end();
}

void PickleWriter::begin_array(const std::vector<std::size_t>& shape) {
  put(kReconstruct);
  put("(K\1(");
  for (const std::size_t size : shape) put_integer(static_cast<std::int64_t>(size));
  put("t");
}

void PickleWriter::put_type(std::string_view word, char order, std::int64_t size,
                            std::int64_t alignment, std::int64_t flags) {
  put("cnumpy\ndtype\n");
  put_text(word);
  put("\x89\x88\x87R(K\3");
  put_text({&order, 1});
  put("NNN");
  for (const std::int64_t number : {size, alignment, flags}) put_integer(number);
  put("tb");
}

void PickleWriter::array(NumberType type, const std::vector<std::size_t>& shape,
                         std::string_view data) {
  if (internal::array_bytes(shape, size_of(type)) != data.size()) {
    throw InvalidArgument("PickleWriter: " + std::to_string(data.size()) +
                          " bytes do not fill an array of that shape");
  }
  count();
  begin_array(shape);
  put_type(numpy_word(type), size_of(type) > 1 ? '<' : '|', -1, -1, 0);
  put("\x89");
  put_bytes(data);
  put("tb");
}

template <class T>
void PickleWriter::array(std::span<const T> values, const std::vector<std::size_t>& shape) {
  constexpr NumberType kType = std::is_same_v<T, float>          ? NumberType::kFloat32
                               : std::is_same_v<T, double>       ? NumberType::kFloat64
                               : std::is_same_v<T, std::int32_t> ? NumberType::kInt32
                               : std::is_same_v<T, std::int64_t> ? NumberType::kInt64
                               : std::is_same_v<T, std::uint8_t> ? NumberType::kUint8
                                                                 : NumberType::kUint32;
  array(kType, shape, {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

template void PickleWriter::array(std::span<const float>, const std::vector<std::size_t>&);
template void PickleWriter::array(std::span<const double>, const std::vector<std::size_t>&);
template void PickleWriter::array(std::span<const std::int32_t>, const std::vector<std::size_t>&);
template void PickleWriter::array(std::span<const std::int64_t>, const std::vector<std::size_t>&);
template void PickleWriter::array(std::span<const std::uint8_t>, const std::vector<std::size_t>&);
template void PickleWriter::array(std::span<const std::uint32_t>, const std::vector<std::size_t>&);

void PickleWriter::texts(std::span<const std::string> values) {
  std::vector<std::u32string> words;
  std::size_t longest = 1;
  for (const std::string& value : values) {
    words.push_back(code_points(value));
    longest = std::max(longest, words.back().size());
  }
  std::string data;
  for (std::u32string& word : words) {
    word.resize(longest, U'\0');
    for (const char32_t point : word) data += little_endian(static_cast<std::uint32_t>(point), 4);
  }
  count();
  begin_array({values.size()});
  put_type("U" + std::to_string(longest), '<', static_cast<std::int64_t>(4 * longest), 4, 8);
  put("\x89");
  put_bytes(data);
  put("tb");
}

std::string PickleWriter::finish() && {
  if (open_.size() != 1 || open_.back().values != 1) {
    throw InvalidArgument("PickleWriter: expected one value, all of it ended");
  }
  open_.clear();
  put(".");
  return std::move(bytes_);
}

std::string encode_npy_object(std::string_view pickle) {
  // The header takes 128 bytes, so that what follows is aligned as NumPy aligns it.
  std::string text = "{'descr': '|O', 'fortran_order': False, 'shape': (), }";
  text.append(117 - text.size(), ' ');
  text += '\n';
  std::string bytes = "\x93NUMPY\1";
  bytes += {'\0', static_cast<char>(text.size()), '\0'};
  return bytes.append(text).append(pickle);
}

}  // namespace arbox::io
