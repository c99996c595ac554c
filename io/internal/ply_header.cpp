#include "arbox/io/internal/ply_header.h"

#include <algorithm>
#include <utility>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/parse.h"

namespace arbox::io::internal {
namespace {

NumberType ply_number_type(std::string_view word, const TextPlace& place) {
  static constexpr std::pair<std::string_view, NumberType> kTypes[] = {
      {"char", NumberType::kInt8},      {"int8", NumberType::kInt8},
      {"uchar", NumberType::kUint8},    {"uint8", NumberType::kUint8},
      {"short", NumberType::kInt16},    {"int16", NumberType::kInt16},
      {"ushort", NumberType::kUint16},  {"uint16", NumberType::kUint16},
      {"int", NumberType::kInt32},      {"int32", NumberType::kInt32},
      {"uint", NumberType::kUint32},    {"uint32", NumberType::kUint32},
      {"float", NumberType::kFloat32},  {"float32", NumberType::kFloat32},
      {"double", NumberType::kFloat64}, {"float64", NumberType::kFloat64},
  };
  for (const auto& [name, type] : kTypes) {
    if (name == word) return type;
  }
  refuse(place, "a PLY number type (char ... double)", quoted_text(word));
}

PlyEncoding encoding_of(const std::vector<std::string_view>& words, const TextPlace& place) {
  if (words.size() == 3 && words[2] == "1.0") {
    if (words[1] == "ascii") return PlyEncoding::kAscii;
    if (words[1] == "binary_little_endian") return PlyEncoding::kBinaryLittleEndian;
    if (words[1] == "binary_big_endian") return PlyEncoding::kBinaryBigEndian;
  }
  refuse(place, "format ascii, binary_little_endian or binary_big_endian 1.0",
         words.size() > 1 ? quoted_text(words[1]) : "nothing");
}

PlyElement element_of(const std::vector<std::string_view>& words, const TextPlace& place) {
  PlyElement element;
  if (words.size() != 3)
    refuse(place, "element NAME COUNT", std::to_string(words.size()) + " words");
  element.name = words[1];
  if (!to_number(words[2], element.count)) {
    refuse(place, "a whole number of elements", quoted_text(words[2]));
  }
  return element;
}

PlyProperty property_of(const std::vector<std::string_view>& words, const TextPlace& place) {
  if (words.size() == 5 && words[1] == "list") {
    const NumberType length = ply_number_type(words[2], place);
    if (is_floating(length))
      refuse(place, "a whole-number type of list lengths", quoted_text(words[2]));
    return {std::string(words[4]), ply_number_type(words[3], place), length};
  }
  if (words.size() != 3) {
    refuse(place, "property TYPE NAME or property list TYPE TYPE NAME",
           std::to_string(words.size()) + " words");
  }
  return {std::string(words[2]), ply_number_type(words[1], place), std::nullopt};
}

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.length_type.has_value(); });
}

std::size_t PlyElement::scalar_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    if (!property.length_type) bytes += size_of(property.type);
  }
  return bytes;
}

PlyHeader parse_ply_header(LineReader& lines) {
  if (!lines.next() || trimmed(lines.line()) != "ply") {
    refuse(lines.place(), "a PLY file (first line 'ply')", quoted_text(lines.line()));
  }
  PlyHeader header;
  bool has_format = false;
  while (lines.next()) {
    const auto words = split_white_space(lines.line());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "format") {
      header.encoding = encoding_of(words, lines.place());
      has_format = true;
    } else if (words[0] == "element") {
      header.elements.push_back(element_of(words, lines.place()));
    } else if (words[0] == "property") {
      if (header.elements.empty())
        refuse(lines.place(), "an element before its properties", "none");
      auto& properties = header.elements.back().properties;
      if (properties.size() == kMostColumns) {
        refuse(lines.place(), "at most " + std::to_string(kMostColumns) + " properties", "more");
      }
      properties.push_back(property_of(words, lines.place()));
    } else if (words[0] == "end_header") {
      if (!has_format) refuse(lines.place(), "a line format before end_header", "none");
      return header;
    } else {
      refuse(lines.place(), "format, element, property, comment or end_header",
             quoted_text(words[0]));
    }
  }
  refuse(lines.place(), "a PLY header that ends with end_header", "the end of the file");
}

}  // namespace arbox::io::internal
