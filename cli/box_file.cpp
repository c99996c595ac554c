#include "arbox/cli/box_file.h"

#include <algorithm>
#include <cctype>

#include "arbox/cli/command_line.h"
#include "arbox/cli/standard_input.h"
#include "arbox/io/box_table.h"
#include "arbox/io/detection_json.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"

namespace arbox::cli {
namespace {

using geometry::Detection;

std::vector<Detection> from_json(const std::filesystem::path& path, const std::string& scan) {
  std::vector<io::ScanDetections> scans =
      path == "-" ? io::parse_detections_json(read_standard_input(), kStandardInput)
                  : io::read_detections_json(path);
  if (scans.empty()) return {};
  if (scans.size() == 1) return std::move(scans.front().detections);
  const auto fits = [&](const io::ScanDetections& one) {
    return std::filesystem::path(one.source).stem() == scan;
  };
  if (std::count_if(scans.begin(), scans.end(), fits) != 1) {
    throw FormatError(path.string() + ": holds " + std::to_string(scans.size()) +
                      " scans, expected exactly one whose source is named '" + scan + "'");
  }
  return std::move(std::find_if(scans.begin(), scans.end(), fits)->detections);
}

std::vector<Detection> from_table(const std::filesystem::path& path) {
  const io::BoxTable table = io::read_box_table(path);
  std::vector<Detection> detections(table.boxes.size());
  for (std::size_t i = 0; i < detections.size(); ++i) {
    detections[i].box = table.boxes[i];
    detections[i].score = table.scores.empty() ? 1.0 : table.scores[i];
    if (!table.classes.empty()) detections[i].label = table.classes[i];
  }
  return detections;
}

std::vector<Detection> from_kitti(const std::filesystem::path& path, KittiText kitti,
                                  const io::KittiCalibration& calibration) {
  std::vector<Detection> detections;
  for (const io::KittiObject& object :
       kitti == KittiText::kResults ? io::read_kitti_results(path) : io::read_kitti_labels(path)) {
    if (!io::has_box(object)) continue;
    Detection& detection = detections.emplace_back();
    detection.label = object.type;
    detection.score = kitti == KittiText::kResults ? object.score : 1.0;
    detection.box = io::to_box(object, calibration);
  }
  return detections;
}

}  // namespace

std::vector<Detection> read_boxes(const std::filesystem::path& path, KittiText kitti,
                                  const std::string& scan,
                                  const std::optional<io::KittiCalibration>& calibration) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (path == "-" || extension == ".json" || extension == ".jsonl") return from_json(path, scan);
  if (extension == ".csv") return from_table(path);
  if (extension != ".txt") {
    throw UsageError(path.string() +
                     ": expected boxes in .json, .jsonl, .csv or KITTI's .txt, got '" + extension +
                     "'");
  }
  if (!calibration) {
    throw UsageError(path.string() +
                     ": boxes of a KITTI file stand in the camera's frame: give --calib FILE");
  }
  return from_kitti(path, kitti, *calibration);
}

}  // namespace arbox::cli
