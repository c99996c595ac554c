#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/kitti_object.h"

/// \file
/// Label and result files of the KITTI object benchmark, in the files' own numbers and frame
/// (docs/formats.md, "KITTI labels and results"). A label line has 15 fields separated by white
/// space, a result line a 16th, the score:
///
///     type truncation occlusion alpha left top right bottom height width length x y z rotation_y
///
/// io/kitti.h turns objects into boxes in the LiDAR frame and back.

namespace arbox::io {

/// True if the object has a place and a size in space (DontCare areas and 2-D detections have not).
bool has_box(const KittiObject& object);

/// Reads label lines. An empty text gives no objects.
///
/// Throws FormatError with file, line, what was expected and what came for other counts of fields,
/// fields that are not finite numbers, a truncation outside of [0, 1], an occlusion that is not
/// 0..3, 2-D boxes with their right or bottom edge before the left or top one, and sizes that are
/// not above zero. Objects of type DontCare may have -1 for truncation, occlusion and sizes.
std::vector<KittiObject> parse_kitti_labels(std::string_view text, std::string_view source);

/// Reads result lines; as labels, but truncation, occlusion and the 2-D box may be any numbers, and
/// all three sizes may be -1 (a detection in the image only).
std::vector<KittiObject> parse_kitti_results(std::string_view text, std::string_view source);

/// The same from a file; throws IoError for a missing file or a directory.
std::vector<KittiObject> read_kitti_labels(const std::filesystem::path& path);
std::vector<KittiObject> read_kitti_results(const std::filesystem::path& path);

/// Label lines, with two decimals as the benchmark's own files have unless told otherwise. Throws
/// InvalidArgument for types that are empty or hold white space, and numbers that are not finite.
std::string format_kitti_labels(std::span<const KittiObject> objects, int decimals = 2);

/// Result lines with four decimals (six of the score). Throws as format_kitti_labels.
std::string format_kitti_results(std::span<const KittiObject> objects);

}  // namespace arbox::io
