#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "arbox/cli/scan_inputs.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/detection_json.h"

namespace arbox::cli {

/// Where and how `arbox detect` writes.
struct OutputOptions {
  /// json, jsonl, kitti, csv or ply.
  std::string format = "json";
  /// Folder for one file a scan (jsonl: one file for all); empty means standard output.
  std::filesystem::path folder = {};
  /// Calibration file, or a folder of NAME.txt, for the kitti format; empty for that of the scans.
  std::filesystem::path calibration = {};
  /// Picture, or a folder of pictures if there are several scans; empty for none.
  std::filesystem::path view = {};
};

/// Writes the detections of scans, one after another, as they come.
class DetectionOutput {
 public:
  /// `scans` are those to come; `several` tells that a folder or more than one file was asked for.
  /// Makes the folders. Throws UsageError for combinations that make no sense, such as two scans
  /// that would be written to one file; IoError.
  DetectionOutput(OutputOptions options, const std::vector<ScanInput>& scans, bool several);

  /// Writes what was found in one scan. Throws IoError, FormatError (calibration).
  void write(const ScanInput& input, std::vector<geometry::Detection> detections,
             const geometry::PointCloudView& cloud);

  /// Ends what is written to standard output or to one file for all.
  void finish();

 private:
  std::string text(const ScanInput& input, const io::ScanDetections& scan) const;
  std::string kitti_text(const ScanInput& input, const io::ScanDetections& scan) const;
  void draw(const io::ScanDetections& scan, const geometry::PointCloudView& cloud) const;

  OutputOptions options_;
  bool several_;
  int written_ = 0;
  std::string lines_;
};

/// The name of a scan's files: that of its source without folder and extension.
std::string scan_name(const std::string& source);

}  // namespace arbox::cli
