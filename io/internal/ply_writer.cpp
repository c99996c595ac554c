#include "arbox/io/internal/point_cloud_encoders.h"

namespace arbox::io::internal {
namespace {

// The names that PLY readers know.
std::string ply_name(const std::string& channel) {
  static constexpr std::pair<std::string_view, std::string_view> kNames[] = {
      {"r", "red"},       {"g", "green"},     {"b", "blue"},
      {"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"},
  };
  for (const auto& [from, to] : kNames) {
    if (from == channel) return std::string(to);
  }
  return channel;
}

bool is_color(const OutputField& field) { return field.type == NumberType::kUint8; }

std::string_view type_word(NumberType type) {
  switch (type) {
    case NumberType::kUint8:
      return "uchar";
    case NumberType::kUint16:
      return "ushort";
    case NumberType::kUint32:
      return "uint";
    default:
      return "float";
  }
}

std::vector<OutputField> ply_fields(const Output& output) {
  std::vector<OutputField> fields{{"x", NumberType::kFloat32, 0},
                                  {"y", NumberType::kFloat32, 1},
                                  {"z", NumberType::kFloat32, 2}};
  for (std::size_t source = 3; source < 3 + output.channels.size(); ++source) {
    const std::string& name = output.channels[source - 3]->name;
    const bool color = name == "r" || name == "g" || name == "b";
    fields.push_back({ply_name(name), color ? NumberType::kUint8 : output.type_of(source), source});
  }
  return fields;
}

}  // namespace

std::string encode_ply(const Output& output, const std::string& encoding) {
  const std::vector<OutputField> fields = ply_fields(output);
  const bool ascii = encoding == "ascii";
  std::string result = std::string("ply\nformat ") + (ascii ? "ascii" : "binary_little_endian") +
                       " 1.0\nelement vertex " + std::to_string(output.points.size()) + "\n";
  for (const OutputField& field : fields) {
    result += "property " + std::string(type_word(field.type)) + " " + field.name + "\n";
  }
  result += "end_header\n";
  for (std::size_t i = 0; i < output.points.size(); ++i) {
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const OutputField& field = fields[f];
      const float value = is_color(field) ? static_cast<float>(output.color_byte(field.source, i))
                                          : output.value(field.source, i);
      if (!ascii) {
        append_number_bytes(result, field.type, value);
        continue;
      }
      if (f > 0) result += ' ';
      append_shortest(result, field.type, value);
    }
    if (ascii) result += '\n';
  }
  return result;
}

}  // namespace arbox::io::internal
