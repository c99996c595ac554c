#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/detection.h"

/// \file
/// Detections as JSON, written and read (docs/formats.md, "Detections as JSON"):
///
///     {"source": "000008.bin", "frame": "lidar", "detections": [{"class": "Car", "score": 0.93,
///      "box": {"center": [x, y, z], "size": [l, w, h], "rotation": [w, x, y, z], "yaw": 0.1}}]}
///
/// Numbers are written in the shortest form that reads back as the same double. `yaw` is written
/// where the rotation is about z. Fields that do not apply are absent.

namespace arbox::io {

/// What a detector found in one scan.
struct ScanDetections {
  /// Where the points came from: the path or name of the file.
  std::string source = {};
  /// Coordinate frame of the boxes; `lidar` is x forward, y left, z up (docs/conventions.md).
  std::string frame = "lidar";
  std::vector<geometry::Detection> detections = {};
};

/// {"center": [x, y, z], "size": [l, w, h], "rotation": [w, x, y, z], "yaw": angle}, on one line;
/// for programs that print their own JSON around boxes. Throws InvalidArgument for an invalid box.
std::string format_box_json(const geometry::Box& box);

/// The box of such an object. Numbers must be finite, sizes above zero, `rotation` a quaternion
/// within 1e-3 of unit norm (it is normalised). Instead of `rotation`, `yaw` alone is accepted; if
/// both are there they must agree within 1e-3 radians. Throws FormatError.
geometry::Box parse_box_json(std::string_view text, std::string_view source);

/// One scan as a JSON object: on one line without a line break at its end if `indent` < 0, else
/// pretty with that many spaces a level. Bytes of names that are not UTF-8 become U+FFFD. Throws
/// InvalidArgument for boxes that are invalid and numbers that are not finite, naming the field.
std::string format_detections_json(const ScanDetections& scan, int indent = -1);

/// Several scans as JSON lines: one object a line, each line ended.
std::string format_detections_jsonl(std::span<const ScanDetections> scans);

/// Reads scans from JSON: one object, an array of objects, or objects one after another (JSON
/// lines). A text of white space alone gives no scans. Required are `detections` and in each of
/// them `box`; `class` and `score` default to "" and 1, so that plain boxes need neither. Further
/// keys of a scan or a detection are passed over; a box may have no others. Throws FormatError that
/// names `source`, the line for what is not JSON, and the path of the field (such as
/// [2]/detections/0/box/size) for all else.
std::vector<ScanDetections> parse_detections_json(std::string_view text, std::string_view source);

/// parse_detections_json of a file; throws IoError for a missing file or a directory.
std::vector<ScanDetections> read_detections_json(const std::filesystem::path& path);

}  // namespace arbox::io
