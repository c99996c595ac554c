#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// Labels of one scan in Arbox' own dataset layout (docs/datasets/own.md): JSON, or text with one
/// object a line.

namespace arbox::io {

struct LabelFile {
  /// The frame that the file names, if it does.
  std::optional<SceneFrame> frame;
  std::vector<LabeledObject> objects;
};

/// Reads one JSON object:
///
///     {"frame": "lidar", "objects": [{"class": "Car", "heading": "known",
///      "box": {"center": [x, y, z], "size": [l, w, h], "yaw": 0.1}, "attributes": {"id": 7}}]}
///
/// Boxes as in io/detection_json.h. `frame`, `heading` ("known", "half" or "unknown") and
/// `attributes` (numbers) may be missing. What `arbox detect` wrote is taken too: the key
/// `detections` stands for `objects`. Other keys are passed over. A text of white space alone is no
/// label file. Throws FormatError with the line of what is no JSON and the path of the key of all
/// else.
LabelFile parse_label_json(std::string_view text, std::string_view source);

/// Reads lines
///
///     x y z length width height yaw class
///
/// Lines that begin with # and empty ones are passed over; no lines are no objects. Throws
/// FormatError with file and line for other counts of fields, numbers that are not finite and sizes
/// that are not above zero.
LabelFile parse_label_text(std::string_view text, std::string_view source);

/// Reads a .json or .txt file. Throws IoError, FormatError.
LabelFile read_label_file(const std::filesystem::path& path);

/// The JSON form, one object a line. Throws InvalidArgument for invalid boxes and attributes that
/// are not finite.
std::string format_label_json(std::span<const LabeledObject> objects, SceneFrame frame);

}  // namespace arbox::io
