#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/load_number.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/ply_header.h"
#include "arbox/io/internal/record_text.h"

namespace arbox::io::internal {
namespace {

// Uninitialised on purpose: every byte is written before it is read.
using Buffer = std::unique_ptr<std::byte[]>;

constexpr std::string_view kVertex = "vertex";

[[noreturn]] void refuse_count(const PlyElement& element, std::size_t bytes,
                               const std::string& name) {
  fail(name, "the header claims " + std::to_string(element.count) + " of element '" + element.name +
                 "', more than the " + std::to_string(bytes) + " bytes after the header hold");
}

std::vector<RecordElement> record_elements(const PlyElement& vertex) {
  std::vector<RecordElement> elements;
  std::size_t offset = 0;
  for (const PlyProperty& property : vertex.properties) {
    if (property.length_type) continue;
    elements.push_back({property.name, property.type, offset});
    offset += size_of(property.type);
  }
  return elements;
}

// The single numbers of a line that also holds lists, joined again.
std::string without_lists(const PlyElement& element, const LineReader& lines) {
  const auto words = split_white_space(lines.line());
  std::string result;
  std::size_t at = 0;
  for (const PlyProperty& property : element.properties) {
    if (at >= words.size()) break;
    if (!property.length_type) {
      result.append(words[at++]).push_back(' ');
      continue;
    }
    std::size_t length = 0;
    if (!to_number(words[at], length) || length > words.size() - at - 1) {
      refuse(lines.place(), "a list's length and as many numbers for " + property.name,
             quoted_text(words[at]));
    }
    at += length + 1;
  }
  if (at < words.size())
    refuse(lines.place(), std::to_string(at) + " numbers", std::to_string(words.size()));
  return result;
}

Buffer read_ascii(const PlyHeader& header, const PlyElement& vertex, LineReader& lines,
                  const std::string& name) {
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) break;
    for (std::size_t i = 0; i < element.count; ++i) {
      if (!lines.next_filled()) refuse_count(element, lines.rest().size(), name);
    }
  }
  const auto elements = record_elements(vertex);
  const std::size_t numbers = std::max<std::size_t>(vertex.properties.size(), 1);
  if (vertex.count > lines.rest().size() / (2 * numbers) + 1) {
    refuse_count(vertex, lines.rest().size(), name);
  }
  const std::size_t stride = vertex.scalar_bytes();
  auto records =
      std::make_unique_for_overwrite<std::byte[]>(stride * std::max<std::size_t>(vertex.count, 1));
  const bool lists = vertex.has_lists();
  for (std::size_t i = 0; i < vertex.count; ++i) {
    if (!lines.next_filled()) {
      refuse(lines.place(), std::to_string(vertex.count) + " vertices as the header says",
             std::to_string(i) + " before the end of the file");
    }
    std::byte* record = records.get() + i * stride;
    if (lists) {
      store_line(without_lists(vertex, lines), elements, record, lines.place());
    } else {
      store_line(lines.line(), elements, record, lines.place());
    }
  }
  return records;
}

// Walks over binary elements whose records differ in length.
class BinaryWalker {
 public:
  BinaryWalker(std::string_view body, std::size_t offset, bool big_endian, const std::string& name)
      : body_(body), offset_(offset), big_endian_(big_endian), name_(name) {}

  const std::byte* here() const { return reinterpret_cast<const std::byte*>(body_.data()) + at_; }

  void skip(std::size_t count, std::size_t stride, const PlyElement& element) {
    if (stride > 0 && count > left() / stride) {
      fail_at_byte(name_, offset_ + at_,
                   "expected " + std::to_string(count) + " records of " + std::to_string(stride) +
                       " bytes of element '" + element.name + "', got " + std::to_string(left()) +
                       " bytes");
    }
    at_ += count * stride;
  }

  // One record; copies its single numbers to `to` unless that is null.
  void record(const PlyElement& element, std::byte* to) {
    for (const PlyProperty& property : element.properties) {
      const std::size_t size = size_of(property.type);
      if (!property.length_type) {
        const std::byte* from = here();
        skip(1, size, element);
        if (to == nullptr) continue;
        std::memcpy(to, from, size);
        to += size;
        continue;
      }
      const std::byte* from = here();
      skip(1, size_of(*property.length_type), element);
      skip(length(*property.length_type, from, property), size, element);
    }
  }

  std::size_t left() const { return body_.size() - at_; }

 private:
  std::size_t length(NumberType type, const std::byte* from, const PlyProperty& property) const {
    return with_type(type, [&](auto number) -> std::size_t {
      number = load_number<decltype(number)>(from, big_endian_);
      const auto value = static_cast<double>(number);
      if (value < 0.0) {
        fail_at_byte(name_, offset_ + at_ - size_of(type),
                     "expected the length of list '" + property.name + "', got " +
                         std::to_string(static_cast<std::int64_t>(value)));
      }
      return static_cast<std::size_t>(value);
    });
  }

  std::string_view body_;
  std::size_t at_ = 0, offset_ = 0;
  bool big_endian_ = false;
  const std::string& name_;
};

// Where the vertices' records start; `owned` holds them if they had to be copied out.
const std::byte* read_binary(const PlyHeader& header, const PlyElement& vertex, BinaryWalker walker,
                             const std::string& name, Buffer& owned) {
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) break;
    if (!element.has_lists()) {
      walker.skip(element.count, element.scalar_bytes(), element);
      continue;
    }
    for (std::size_t i = 0; i < element.count; ++i) walker.record(element, nullptr);
  }
  const std::size_t stride = vertex.scalar_bytes();
  if (!vertex.has_lists()) {
    const std::byte* first = walker.here();
    walker.skip(vertex.count, stride, vertex);
    return first;
  }
  // A list takes at least the byte of its length.
  if (vertex.count > walker.left() / (stride + 1)) refuse_count(vertex, walker.left(), name);
  owned =
      std::make_unique_for_overwrite<std::byte[]>(std::max<std::size_t>(vertex.count, 1) * stride);
  for (std::size_t i = 0; i < vertex.count; ++i) walker.record(vertex, owned.get() + i * stride);
  return owned.get();
}

std::string_view encoding_name(PlyEncoding encoding) {
  switch (encoding) {
    case PlyEncoding::kAscii:
      return "ascii";
    case PlyEncoding::kBinaryLittleEndian:
      return "binary_little_endian";
    case PlyEncoding::kBinaryBigEndian:
      return "binary_big_endian";
  }
  return "";
}

}  // namespace

PointCloudFile parse_ply(std::string_view content, const std::string& name,
                         const ReadOptions& options) {
  require_no_channels(name, options);
  if (content.empty()) fail(name, "expected a PLY file, got an empty file");
  LineReader lines(content, name);
  const PlyHeader header = parse_ply_header(lines);
  const auto vertex =
      std::find_if(header.elements.begin(), header.elements.end(),
                   [](const PlyElement& element) { return element.name == kVertex; });
  if (vertex == header.elements.end()) fail(name, "expected an element 'vertex', got none");
  const bool big_endian = header.encoding == PlyEncoding::kBinaryBigEndian;
  Buffer owned;
  const std::byte* records = nullptr;
  if (header.encoding == PlyEncoding::kAscii) {
    owned = read_ascii(header, *vertex, lines, name);
    records = owned.get();
  } else {
    const std::string_view body = lines.rest();
    const BinaryWalker walker(body, content.size() - body.size(), big_endian, name);
    records = read_binary(header, *vertex, walker, name, owned);
  }
  std::vector<Column> columns;
  const std::size_t stride = vertex->scalar_bytes();
  for (const RecordElement& element : record_elements(*vertex)) {
    columns.push_back({element.name, element.type, records + element.offset, stride, big_endian});
  }
  return assemble(std::move(columns),
                  {.format = PointCloudFormat::kPly,
                   .encoding = std::string(encoding_name(header.encoding)),
                   .points_in_file = vertex->count,
                   .width = vertex->count},
                  name, options);
}

}  // namespace arbox::io::internal
