#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/io/point_cloud_file.h"

/// \file
/// The scans that `arbox detect` is asked for.

namespace arbox::cli {

struct ScanInput {
  /// The file of the points, - for standard input.
  std::string source;
  /// Of a frame of KITTI data: its calibration and its image, which need not be there.
  std::filesystem::path calibration = {}, image = {};

  bool is_kitti_frame() const { return !calibration.empty(); }
};

/// The scans of `inputs`: files, folders of them, or with a split the frames of KITTI roots.
/// `on_failure` gets the folders that cannot be used if there are other inputs; a single one's
/// error is thrown. Throws UsageError for a KITTI root without a split, naming those that there
/// are, for a split of what is no KITTI root, and for an unknown split; IoError, FormatError for
/// its list.
std::vector<ScanInput> list_scans(const std::vector<std::string>& inputs, const std::string& split,
                                  const std::function<void(const Error&)>& on_failure);

/// The points of a scan. KITTI frames have the four columns of the benchmark unless the options
/// name others. Throws as io::read_point_cloud.
io::PointCloudFile read_scan(const ScanInput& scan, io::ReadOptions options);

}  // namespace arbox::cli
