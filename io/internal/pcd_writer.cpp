#include <algorithm>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/io/internal/lzf.h"
#include "arbox/io/internal/point_cloud_encoders.h"

namespace arbox::io::internal {
namespace {

constexpr std::string_view kPackedColor = "rgb";

std::vector<OutputField> fields_of(const Output& output) {
  std::vector<OutputField> fields{{"x", NumberType::kFloat32, 0},
                                  {"y", NumberType::kFloat32, 1},
                                  {"z", NumberType::kFloat32, 2}};
  const bool color = output.find("r") > 0 && output.find("g") > 0 && output.find("b") > 0;
  for (std::size_t source = 3; source < 3 + output.channels.size(); ++source) {
    const std::string& name = output.channels[source - 3]->name;
    if (color && name == "r")
      fields.push_back({std::string(kPackedColor), NumberType::kUint32, source});
    if (color && (name == "r" || name == "g" || name == "b")) continue;
    fields.push_back({name, output.type_of(source), source});
  }
  return fields;
}

std::string header_of(const std::vector<OutputField>& fields, std::size_t points,
                      const std::string& encoding) {
  std::string names = "FIELDS", sizes = "SIZE", types = "TYPE", counts = "COUNT";
  for (const OutputField& field : fields) {
    names += " " + field.name;
    sizes += " " + std::to_string(size_of(field.type));
    types += is_floating(field.type) ? " F" : " U";
    counts += " 1";
  }
  const std::string number = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + names + "\n" + sizes + "\n" +
         types + "\n" + counts + "\nWIDTH " + number +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + number + "\nDATA " + encoding + "\n";
}

// r, g and b in one number, blue in the lowest byte.
std::uint32_t packed_color(const Output& output, std::size_t i) {
  std::uint32_t color = 0;
  for (const char* name : {"r", "g", "b"}) {
    color = color << 8 | output.color_byte(output.find(name), i);
  }
  return color;
}

void append_binary(std::string& bytes, const Output& output, const OutputField& field,
                   std::size_t i) {
  if (field.name == kPackedColor) {
    const std::uint32_t color = packed_color(output, i);
    bytes.append(reinterpret_cast<const char*>(&color), sizeof color);
  } else {
    append_number_bytes(bytes, field.type, output.value(field.source, i));
  }
}

std::string compressed(const Output& output, const std::vector<OutputField>& fields) {
  std::string blocks;
  for (const OutputField& field : fields) {
    for (std::size_t i = 0; i < output.points.size(); ++i) append_binary(blocks, output, field, i);
  }
  const std::string stream = lzf_compress(blocks);
  if (std::max(stream.size(), blocks.size()) > std::numeric_limits<std::uint32_t>::max()) {
    throw InvalidArgument(
        "encode_point_cloud: binary_compressed PCD holds at most 4 GiB; use binary");
  }
  const std::uint32_t sizes[] = {static_cast<std::uint32_t>(stream.size()),
                                 static_cast<std::uint32_t>(blocks.size())};
  return std::string(reinterpret_cast<const char*>(sizes), sizeof sizes) + stream;
}

}  // namespace

std::string encode_pcd(const Output& output, const std::string& encoding) {
  const std::vector<OutputField> fields = fields_of(output);
  std::string result = header_of(fields, output.points.size(), encoding);
  if (encoding == "binary_compressed") return result + compressed(output, fields);
  for (std::size_t i = 0; i < output.points.size(); ++i) {
    for (std::size_t f = 0; f < fields.size(); ++f) {
      if (encoding == "binary") {
        append_binary(result, output, fields[f], i);
        continue;
      }
      if (f > 0) result += ' ';
      if (fields[f].name == kPackedColor) {
        result += std::to_string(packed_color(output, i));
      } else {
        append_shortest(result, fields[f].type, output.value(fields[f].source, i));
      }
    }
    if (encoding == "ascii") result += '\n';
  }
  return result;
}

}  // namespace arbox::io::internal
