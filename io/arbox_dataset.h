#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// Arbox' own dataset layout, for data that people record and label themselves
/// (docs/datasets/own.md):
///
///     ROOT/dataset.json            frame, classes, class map, columns of .bin files; all optional
///     ROOT/points/NAME.EXT         any point cloud that `arbox info` reads
///     ROOT/labels/NAME.json|txt    labels (io/label_file.h); a scan without one is not labelled
///     ROOT/images/NAME.png|jpg     optional
///     ROOT/calib/NAME.json|txt     optional, or ROOT/calib.json|txt for all
///     ROOT/splits/SPLIT.txt        optional, one NAME a line

namespace arbox::io {

/// What dataset.json says.
struct DatasetDescription {
  SceneFrame frame = SceneFrame::kLidar;
  /// Class names in their order; empty takes any.
  std::vector<std::string> classes = {};
  /// Names in label files that stand for another class, or for nothing at all (null).
  std::map<std::string, std::optional<std::string>> class_map = {};
  /// Columns of clouds that do not name theirs, as ReadOptions::channels.
  std::vector<std::string> columns = {};
};

/// Reads dataset.json. Throws FormatError with the path of the key; unknown keys are refused.
DatasetDescription parse_dataset_description(std::string_view text, std::string_view source);

/// The content of such a file.
std::string format_dataset_description(const DatasetDescription& description);

/// A camera of a scan: calib/NAME.json.
struct CameraFile {
  /// From the scan's frame to pixels, as ScenePhoto::projection.
  Projection projection = Projection::Zero();
  ImageSize size;
};

/// Reads {"projection": [[4 numbers], [4], [4]], "image_size": [width, height]}; the size may be
/// missing. Throws FormatError.
CameraFile parse_camera_json(std::string_view text, std::string_view source);
std::string format_camera_json(const CameraFile& camera);

/// What init_dataset found and did.
struct InitReport {
  /// Folders and files that were made.
  std::vector<std::string> made;
  /// What remains to be done, one sentence each.
  std::vector<std::string> notes;
  std::size_t scans = 0, labels = 0;
  std::vector<std::string> classes;
};

/// Prepares a folder: makes what is missing of the layout. Without classes in `description` those
/// of the labels go into dataset.json, the most frequent first. If there are scans and no splits,
/// every fifth goes to splits/val.txt and the others to splits/train.txt. Files that exist are
/// never changed. Throws IoError, FormatError for label files that cannot be read.
InitReport init_dataset(const std::filesystem::path& root, const DatasetDescription& description);

}  // namespace arbox::io
