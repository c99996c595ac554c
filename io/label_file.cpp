#include "arbox/io/label_file.h"

#include <array>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/box_json.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/json.h"

namespace arbox::io {
namespace {

constexpr std::size_t kNumbers = 7;
constexpr std::size_t kKittiLabelFields = 15;
constexpr std::array<std::string_view, kNumbers> kNames = {"x",     "y",      "z",  "length",
                                                           "width", "height", "yaw"};

template <class Parse>
auto parsed_word(const JsonCursor& value, const Parse& parse) {
  try {
    return parse(value.text());
  } catch (const InvalidArgument& error) {
    throw FormatError(value.place() + ": " + error.what());
  }
}

std::map<std::string, double> read_attributes(const JsonCursor& value) {
  value.require_object();
  std::map<std::string, double> attributes;
  for (const std::string& key : value.keys()) attributes[key] = value.at(key.c_str()).number();
  return attributes;
}

LabeledObject read_object(const JsonCursor& value) {
  value.require_object();
  LabeledObject object;
  if (value.has("class")) object.label = value.at("class").text();
  object.box = internal::read_box(value.at("box"));
  if (value.at("box").has("yaw")) object.written_yaw = value.at("box").at("yaw").number();
  if (value.has("heading")) object.heading = parsed_word(value.at("heading"), heading_named);
  if (value.has("attributes")) object.attributes = read_attributes(value.at("attributes"));
  return object;
}

LabeledObject read_line(const internal::LineReader& lines) {
  const auto place = lines.place();
  const auto fields = internal::split_white_space(lines.line());
  if (fields.size() == kKittiLabelFields || fields.size() == kKittiLabelFields + 1) {
    internal::refuse(place, "x y z length width height yaw class",
                     "a line of " + std::to_string(fields.size()) +
                         " fields as KITTI's labels have; these belong into KITTI's layout, with "
                         "a calibration");
  }
  if (fields.size() != kNumbers + 1) {
    internal::refuse(place, "8 fields: x y z length width height yaw class",
                     std::to_string(fields.size()));
  }
  std::array<double, kNumbers> v{};
  for (std::size_t i = 0; i < kNumbers; ++i) {
    v[i] = internal::parse_number(fields[i], kNames[i], place);
    if (i >= 3 && i < 6 && v[i] <= 0.0) {
      internal::refuse(place, "a size above zero as " + std::string(kNames[i]),
                       internal::quoted_text(fields[i]));
    }
  }
  return {.label = std::string(fields[kNumbers]),
          .box = geometry::make_yaw_box({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6]),
          .written_yaw = v[6]};
}

}  // namespace

LabelFile parse_label_json(std::string_view text, std::string_view source) {
  const auto values = parse_json_values(text, source);
  if (values.size() != 1 || !values[0].is_object()) {
    throw FormatError(std::string(source) +
                      ": expected one JSON object with the key objects, got " +
                      (values.empty() ? "nothing" : "something else"));
  }
  const JsonCursor root(values[0], std::string(source) + ": ");
  LabelFile file;
  if (root.has("frame")) file.frame = parsed_word(root.at("frame"), frame_named);
  const bool detections = !root.has("objects") && root.has("detections");
  for (const JsonCursor& item : root.at(detections ? "detections" : "objects").elements()) {
    file.objects.push_back(read_object(item));
  }
  return file;
}

LabelFile parse_label_text(std::string_view text, std::string_view source) {
  LabelFile file;
  internal::LineReader lines(text, source);
  while (lines.next_filled()) {
    if (internal::trimmed(lines.line()).front() == '#') continue;
    file.objects.push_back(read_line(lines));
  }
  return file;
}

LabelFile read_label_file(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  return path.extension() == ".json" ? parse_label_json(text, path.string())
                                     : parse_label_text(text, path.string());
}

std::string format_label_json(std::span<const LabeledObject> objects, SceneFrame frame) {
  std::string text = "{\"frame\": \"" + std::string(name_of(frame)) + "\", \"objects\": [";
  const char* separator = "\n  ";
  for (const LabeledObject& object : objects) {
    Json json = {{"class", object.label}, {"box", internal::box_json(object.box)}};
    if (object.heading != Heading::kKnown) json["heading"] = name_of(object.heading);
    for (const auto& [name, number] : object.attributes) {
      if (!std::isfinite(number)) {
        throw InvalidArgument("format_label_json: attribute " + internal::quoted_text(name) +
                              " must be finite, got " + std::to_string(number));
      }
      json["attributes"][name] = number;
    }
    text.append(separator).append(dump_json(json, -1));
    separator = ",\n  ";
  }
  return text + (objects.empty() ? "]}\n" : "\n]}\n");
}

}  // namespace arbox::io
