#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// ScanNet v2: its classes, the files of the raw release and how boxes are made of them
/// (docs/datasets/scannet.md). open_dataset() reads whole folders.

namespace arbox::io {

/// One of the 18 classes of the detection benchmark, in the benchmark's order.
struct ScanNetClass {
  std::string_view name;
  int nyu40_id;
};
std::span<const ScanNetClass> scannet_classes();

/// Names of scannet_classes().
std::vector<std::string> scannet_class_names();

/// The name of an NYU40 id: the benchmark's if it is one of the 18 (`garbagebin`, not `garbage
/// bin`), otherwise NYU40's own. Empty for 0 and numbers out of 1..40.
std::string_view nyu40_name(int id);

/// The NYU40 id of such a name; 0 for others.
int nyu40_id(std::string_view name);

/// An object of SCENE.aggregation.json.
struct ScanNetGroup {
  /// Counted from 0 in the file.
  std::int64_t object_id = 0;
  /// The annotator's word, a raw_category of the label map.
  std::string label;
  /// Segments that it is made of.
  std::vector<std::int64_t> segments;
};

/// Reads SCENE.aggregation.json or SCENE_vh_clean.aggregation.json (key segGroups). Throws
/// FormatError.
std::vector<ScanNetGroup> parse_scannet_aggregation(std::string_view text, std::string_view source);

/// Reads SCENE_vh_clean_2.0.010000.segs.json: the segment of each vertex (key segIndices). Throws
/// FormatError. Memory: 8 bytes a vertex.
std::vector<std::int64_t> parse_scannet_segments(std::string_view text, std::string_view source);

/// What the two read, with the keys that ScanNet's own tools write.
std::string format_scannet_aggregation(std::string_view scene,
                                       std::span<const ScanNetGroup> groups);
std::string format_scannet_segments(std::string_view scene, std::span<const std::int64_t> segments);

/// Reads the line `axisAlignment = ` (16 numbers, rows first) of SCENE.txt: from the scan's frame
/// to the aligned one. Identity if there is no such line. Throws FormatError for other counts,
/// numbers that are not finite and matrices that are no rigid motion within 1e-3.
Eigen::Matrix4d parse_scannet_alignment(std::string_view text, std::string_view source);

/// Reads scannetv2-labels.combined.tsv: raw_category to nyu40id. Throws FormatError for a missing
/// column and ids that are not 0..40.
std::map<std::string, int> parse_scannet_label_map(std::string_view text, std::string_view source);

/// Moves the points (first three numbers of each row) by a rigid matrix, in double, rounded to
/// float32 once.
void align(geometry::PointCloud& cloud, const Eigen::Matrix4d& matrix);

/// Boxes around instances: for each id 1..`instances` the axis-aligned hull of the points whose
/// entry in `instance_of_point` (0 is none) is that id, computed in float32 as ScanNet's and
/// VoteNet's tools do; flat ones are 1e-6 m thick. Ids without points give a box of size 0 0 0,
/// which is no valid box.
std::vector<geometry::Box> instance_boxes(const geometry::PointCloud& cloud,
                                          std::span<const std::int32_t> instance_of_point,
                                          std::size_t instances);

}  // namespace arbox::io
