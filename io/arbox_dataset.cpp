#include "arbox/io/arbox_dataset.h"

#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/json.h"

namespace arbox::io {
namespace {

constexpr const char* kFormat = "arbox dataset";
constexpr double kVersion = 1;

std::vector<std::string> words(const JsonCursor& value) {
  std::vector<std::string> result;
  for (const JsonCursor& word : value.elements()) result.push_back(word.text());
  return result;
}

std::map<std::string, std::optional<std::string>> class_map(const JsonCursor& value) {
  std::map<std::string, std::optional<std::string>> result;
  for (const std::string& key : value.keys()) {
    const JsonCursor to = value.at(key.c_str());
    result[key] = to.is_null() ? std::nullopt : std::optional(to.text());
  }
  return result;
}

JsonCursor only_object(const std::vector<Json>& values, std::string_view source) {
  if (values.size() == 1 && values[0].is_object()) return {values[0], std::string(source) + ": "};
  throw FormatError(std::string(source) + ": expected one JSON object, got " +
                    (values.empty() ? "nothing" : "something else"));
}

SceneFrame read_frame(const JsonCursor& value) {
  const std::string name = value.text();
  for (const SceneFrame frame : {SceneFrame::kLidar, SceneFrame::kRoom, SceneFrame::kCamera}) {
    if (name_of(frame) == name) return frame;
  }
  value.refuse("lidar, room or camera");
}

int read_pixels(const JsonCursor& value) {
  const double number = value.number();
  if (number != std::floor(number) || number < 1 || number > 1 << 20) {
    value.refuse("a whole number of pixels");
  }
  return static_cast<int>(number);
}

}  // namespace

DatasetDescription parse_dataset_description(std::string_view text, std::string_view source) {
  const auto values = parse_json_values(text, source);
  const JsonCursor root = only_object(values, source);
  root.require_object({"format", "version", "frame", "classes", "class_map", "columns"});
  if (root.at("format").text() != kFormat)
    root.at("format").refuse("'" + std::string(kFormat) + "'");
  if (root.at("version").number() != kVersion) root.at("version").refuse("version 1");
  DatasetDescription result;
  if (root.has("frame")) result.frame = read_frame(root.at("frame"));
  if (root.has("classes")) result.classes = words(root.at("classes"));
  if (root.has("class_map")) result.class_map = class_map(root.at("class_map"));
  if (root.has("columns")) result.columns = words(root.at("columns"));
  return result;
}

std::string format_dataset_description(const DatasetDescription& description) {
  Json json = {{"format", kFormat}, {"version", 1}, {"frame", name_of(description.frame)}};
  json["classes"] = description.classes;
  json["class_map"] = Json::object();
  for (const auto& [from, to] : description.class_map) {
    json["class_map"][from] = to ? Json(*to) : Json();
  }
  if (!description.columns.empty()) json["columns"] = description.columns;
  return dump_json(json, 2) + "\n";
}

CameraFile parse_camera_json(std::string_view text, std::string_view source) {
  const auto values = parse_json_values(text, source);
  const JsonCursor root = only_object(values, source);
  root.require_object({"projection", "image_size"});
  CameraFile camera;
  const auto rows = root.at("projection").elements();
  if (rows.size() != 3) root.at("projection").refuse("three rows of four numbers");
  for (std::size_t row = 0; row < 3; ++row) {
    const auto numbers = rows[row].elements();
    if (numbers.size() != 4) rows[row].refuse("four numbers");
    for (std::size_t column = 0; column < 4; ++column) {
      camera.projection(static_cast<int>(row), static_cast<int>(column)) = numbers[column].number();
    }
  }
  if (root.has("image_size")) {
    const auto size = root.at("image_size").elements();
    if (size.size() != 2) root.at("image_size").refuse("[width, height]");
    camera.size = {read_pixels(size[0]), read_pixels(size[1])};
  }
  return camera;
}

std::string format_camera_json(const CameraFile& camera) {
  Json json = {{"projection", Json::array()}};
  for (int row = 0; row < 3; ++row) {
    Json numbers = Json::array();
    for (int column = 0; column < 4; ++column) numbers.push_back(camera.projection(row, column));
    json["projection"].push_back(numbers);
  }
  if (camera.size.width > 0) json["image_size"] = {camera.size.width, camera.size.height};
  return dump_json(json, 2) + "\n";
}

}  // namespace arbox::io
