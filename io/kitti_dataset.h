#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/kitti_object.h"

/// \file
/// A folder in the layout of the KITTI object benchmark:
///
///     ROOT/ImageSets/{train,val,test,...}.txt           one frame name a line
///     ROOT/training/{velodyne,label_2,calib,image_2,planes}/000000.{bin,txt,txt,png,txt}
///     ROOT/testing/{velodyne,calib,image_2,planes}/...

namespace arbox::io {

/// Reads frame names, one a line. Throws FormatError with file and line for names that are doubled
/// or have characters other than letters, digits, '_', '-' and '.', or begin with '.'.
std::vector<std::string> parse_kitti_split(std::string_view text, std::string_view source);
std::vector<std::string> read_kitti_split(const std::filesystem::path& path);

/// Points of a velodyne/ID.bin: rows of four little-endian float32 numbers x, y, z (metres, LiDAR
/// frame) and intensity (0..1), kept as they are. Throws FormatError if the file is empty or not a
/// multiple of 16 bytes, IoError for a missing file or a directory.
geometry::PointCloud read_kitti_scan(const std::filesystem::path& path);

/// Points of such a file by its size alone; throws as read_kitti_scan.
std::int64_t count_kitti_points(const std::filesystem::path& path);

/// Where the files of a frame are, or would be.
struct KittiPaths {
  std::filesystem::path scan, label, calibration, image, plane;
};

/// Everything of one frame.
struct KittiFrame {
  std::string id;
  /// Columns x, y, z, intensity in the LiDAR frame.
  geometry::PointCloud cloud;
  KittiCalibration calibration;
  /// Empty for the testing folder, which has no labels.
  std::vector<KittiObject> labels;
  std::optional<KittiPlane> plane;
  /// The left colour image; empty if it is not there.
  std::filesystem::path image;
  /// Its size; that of the recording day (known_image_size) if the image is not there.
  std::optional<ImageSize> image_size;
};

class KittiDataset {
 public:
  /// Opens ROOT. Throws IoError unless it is a folder with `training` or `testing` in it.
  static KittiDataset open(const std::filesystem::path& root);

  const std::filesystem::path& root() const { return root_; }

  /// Names of the splits: the files of ImageSets, then `training` and `testing`, which are all
  /// frames found in those folders. Each sorted.
  std::vector<std::string> splits() const;

  /// The frames of a split, in the order of its file. Throws InvalidArgument, with the names that
  /// there are, for an unknown split, and as read_kitti_split.
  std::vector<std::string> frames(std::string_view split) const;

  /// The folder that a split's frames are in: `testing` for the splits `test` and `testing`,
  /// `training` for all others.
  static std::string_view folder(std::string_view split);

  KittiPaths paths(std::string_view split, std::string_view id) const;

  /// Reads a frame. The scan, the calibration and, for `training`, the label must be there; the
  /// plane and the image may be missing. Throws as their readers do.
  KittiFrame load(std::string_view split, std::string_view id) const;

 private:
  explicit KittiDataset(std::filesystem::path root) : root_(std::move(root)) {}

  std::filesystem::path root_;
};

}  // namespace arbox::io
