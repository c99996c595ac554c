#include "arbox/io/detection_json.h"

#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/box_json.h"
#include "arbox/io/internal/rotation.h"
#include "arbox/io/json.h"

namespace arbox::io {
namespace {

using geometry::Box;
using geometry::Detection;

constexpr double kYawTolerance = 1e-3;

Json numbers(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

double finite(double number, const char* field) {
  if (!std::isfinite(number)) {
    throw InvalidArgument(std::string("format_detections_json: ") + field +
                          " must be finite, got " + std::to_string(number));
  }
  return number;
}

Eigen::Vector3d read_vector(const JsonCursor& value) {
  const auto elements = value.elements();
  if (elements.size() != 3) value.refuse("three numbers");
  return {elements[0].number(), elements[1].number(), elements[2].number()};
}

Eigen::Vector3d read_size(const JsonCursor& value) {
  const Eigen::Vector3d size = read_vector(value);
  if ((size.array() <= 0.0).any()) value.refuse("three sizes above zero");
  return size;
}

geometry::Quaternion read_rotation(const JsonCursor& value) {
  const auto e = value.elements();
  if (e.size() != 4) value.refuse("four numbers [w, x, y, z]");
  const geometry::Quaternion rotation(e[0].number(), e[1].number(), e[2].number(), e[3].number());
  if (const auto accepted = internal::accepted_rotation(rotation)) return *accepted;
  value.refuse("a unit quaternion (norm 1 within 1e-3, this one's is " +
               std::to_string(rotation.norm()) + ")");
}

}  // namespace

Json internal::box_json(const Box& box) {
  geometry::require_valid(box, "format_detections_json");
  const auto& q = box.rotation;
  Json result = {{"center", numbers(box.center)},
                 {"size", numbers(box.size)},
                 {"rotation", {q.w(), q.x(), q.y(), q.z()}}};
  if (geometry::is_yaw_only(box)) result["yaw"] = geometry::yaw(box);
  return result;
}

Box internal::read_box(const JsonCursor& value) {
  value.require_object({"center", "size", "rotation", "yaw"});
  Box box{.center = read_vector(value.at("center")), .size = read_size(value.at("size"))};
  if (!value.has("rotation")) {
    return geometry::make_yaw_box(box.center, box.size, value.at("yaw").number());
  }
  box.rotation = read_rotation(value.at("rotation"));
  if (value.has("yaw")) {
    const double difference = value.at("yaw").number() - geometry::yaw(box);
    if (std::abs(geometry::wrap_angle(difference)) > kYawTolerance) {
      value.at("yaw").refuse("the yaw of 'rotation', " + std::to_string(geometry::yaw(box)));
    }
  }
  return box;
}

namespace {

using internal::box_json;
using internal::read_box;

Json detection_to_json(const Detection& detection) {
  Json result;
  result["class"] = detection.label;
  result["score"] = finite(detection.score, "score");
  result["box"] = box_json(detection.box);
  if (detection.log_density) result["log_density"] = finite(*detection.log_density, "log_density");
  for (const auto& [q, box, fallback] : detection.quantile_boxes) {
    result["quantile_boxes"].push_back(
        {{"q", finite(q, "q")}, {"box", box_json(box)}, {"fallback", fallback}});
  }
  for (const auto& [p, box] : detection.confidence_boxes) {
    result["confidence_boxes"].push_back({{"p", finite(p, "p")}, {"box", box_json(box)}});
  }
  if (detection.uncertainty) result["uncertainty"] = finite(*detection.uncertainty, "uncertainty");
  if (detection.known_size) {
    for (const double extent : detection.known_size->size) finite(extent, "known_size");
    result["known_size"] = numbers(detection.known_size->size);
    if (!detection.known_size->name.empty()) {
      result["known_size_name"] = detection.known_size->name;
    }
  }
  for (const Box& sample : detection.samples) result["samples"].push_back(box_json(sample));
  return result;
}

Detection read_detection(const JsonCursor& value) {
  value.require_object();
  Detection result;
  result.label = value.has("class") ? value.at("class").text() : "";
  result.score = value.has("score") ? value.at("score").number() : 1.0;
  result.box = read_box(value.at("box"));
  if (value.has("log_density")) result.log_density = value.at("log_density").number();
  if (value.has("uncertainty")) result.uncertainty = value.at("uncertainty").number();
  if (value.has("known_size")) {
    result.known_size = {
        .name = value.has("known_size_name") ? value.at("known_size_name").text() : "",
        .size = read_size(value.at("known_size"))};
  }
  if (value.has("quantile_boxes")) {
    for (const auto& item : value.at("quantile_boxes").elements()) {
      item.require_object({"q", "box", "fallback"});
      result.quantile_boxes.push_back(
          {.q = item.at("q").number(),
           .box = read_box(item.at("box")),
           .fallback = item.has("fallback") && item.at("fallback").boolean()});
    }
  }
  if (value.has("confidence_boxes")) {
    for (const auto& item : value.at("confidence_boxes").elements()) {
      item.require_object({"p", "box"});
      result.confidence_boxes.push_back(
          {.p = item.at("p").number(), .box = read_box(item.at("box"))});
    }
  }
  if (value.has("samples")) {
    for (const auto& item : value.at("samples").elements()) {
      result.samples.push_back(read_box(item));
    }
  }
  return result;
}

Json to_json(const ScanDetections& scan) {
  Json result = {{"source", scan.source}, {"frame", scan.frame}, {"detections", Json::array()}};
  for (const Detection& detection : scan.detections) {
    result["detections"].push_back(detection_to_json(detection));
  }
  return result;
}

ScanDetections read_scan(const JsonCursor& value) {
  value.require_object();
  ScanDetections scan;
  if (value.has("source")) scan.source = value.at("source").text();
  if (value.has("frame")) scan.frame = value.at("frame").text();
  for (const auto& item : value.at("detections").elements()) {
    scan.detections.push_back(read_detection(item));
  }
  return scan;
}

}  // namespace

std::string format_box_json(const geometry::Box& box) { return dump_json(box_json(box), -1); }

geometry::Box parse_box_json(std::string_view text, std::string_view source) {
  const auto values = parse_json_values(text, source);
  if (values.size() != 1) {
    throw FormatError(std::string(source) + ": expected one box object, got " +
                      std::to_string(values.size()) + " values");
  }
  return read_box({values[0], std::string(source)});
}

std::string format_detections_json(const ScanDetections& scan, int indent) {
  return dump_json(to_json(scan), indent);
}

std::string format_detections_jsonl(std::span<const ScanDetections> scans) {
  std::string text;
  for (const ScanDetections& scan : scans) text += format_detections_json(scan) + '\n';
  return text;
}

std::vector<ScanDetections> parse_detections_json(std::string_view text, std::string_view source) {
  std::vector<ScanDetections> scans;
  for (const auto& value : parse_json_values(text, source)) {
    scans.push_back(
        read_scan({value, std::string(source) + ": [" + std::to_string(scans.size()) + "]"}));
  }
  return scans;
}

std::vector<ScanDetections> read_detections_json(const std::filesystem::path& path) {
  return parse_detections_json(read_file(path), path.string());
}

}  // namespace arbox::io
