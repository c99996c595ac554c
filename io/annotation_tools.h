#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// Label files of annotation tools (docs/datasets/own.md, "Labels from annotation tools").

namespace arbox::io {

/// Unit of the angles of labelCloud's centroid files: degrees (`centroid_abs`) or radians
/// (`centroid_rel`); the files do not say.
enum class AngleUnit { kDegrees, kRadians };

/// One file of labelCloud in its forms `centroid_abs`, `centroid_rel` and `vertices`.
struct LabelCloudFile {
  /// The cloud's file name, without folders; empty if the file does not name one.
  std::string cloud;
  std::vector<LabeledObject> objects;
  /// Largest magnitude of an angle in the file; above a full turn it must be degrees.
  double largest_angle = 0.0;
};

/// Reads an object with the key objects, of which each has name and either centroid, dimensions and
/// rotations (about x, then y, then z) or eight vertices. Throws FormatError with the path of the
/// key.
LabelCloudFile parse_labelcloud_json(std::string_view text, std::string_view source,
                                     AngleUnit unit);

/// Reads lines of labelCloud's `kitti_untransformed`: KITTI's 15 fields, but place and angle are in
/// the cloud's frame and the place is the centre. Throws as parse_kitti_labels.
std::vector<LabeledObject> parse_labelcloud_kitti(std::string_view text, std::string_view source);

/// Boxes by frame number.
using Tracklets = std::map<std::int64_t, std::vector<LabeledObject>>;

/// Reads tracklet_labels.xml as CVAT exports it ("Kitti Raw Format 1.0"). There, other than in
/// KITTI's own files, `w h l` are the extents along the box's x, y and z, and tx ty tz is the
/// centre; rotations are about x, then y, then z, radians. Poses that fill gaps (truncation 2
/// or 99, out of the image) are left out. Throws FormatError.
Tracklets parse_cvat_tracklets(std::string_view text, std::string_view source);

/// labelCloud's form `vertices`, the only one of its forms that holds any rotation and needs no
/// word on units: {"folder": "pointclouds", "filename": CLOUD, "path": .., "objects": [..]}. Throws
/// InvalidArgument for invalid boxes.
std::string format_labelcloud_vertices(std::span<const LabeledObject> objects,
                                       std::string_view cloud);

/// labels/_classes.json, by which labelCloud opens a folder in the form `vertices`.
std::string format_labelcloud_classes(std::span<const std::string> classes);

/// tracklet_labels.xml as CVAT reads and writes it, a track of one pose for each box. Throws
/// InvalidArgument for invalid boxes.
std::string format_cvat_tracklets(const Tracklets& tracklets);

}  // namespace arbox::io
