#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arbox/geometry/detection.h"
#include "arbox/io/kitti_calibration.h"

/// \file
/// Boxes of one scan from any file that a person may have them in.

namespace arbox::cli {

/// What a KITTI text file holds: labels, or results with a score.
enum class KittiText { kLabels, kResults };

/// Reads boxes in the LiDAR frame; the extension chooses: .json and .jsonl detections (of several
/// scans the one whose source has the stem `scan`; also what comes on standard input, for the path
/// "-"), .csv box tables, .txt KITTI labels or results,
/// whose objects without a box in space (DontCare) are left out.
///
/// Throws UsageError for another extension and for .txt without a calibration, FormatError for bad
/// content and for JSON of several scans of which not exactly one fits, IoError.
std::vector<geometry::Detection> read_boxes(const std::filesystem::path& path, KittiText kitti,
                                            const std::string& scan,
                                            const std::optional<io::KittiCalibration>& calibration);

}  // namespace arbox::cli
