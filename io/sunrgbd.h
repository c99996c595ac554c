#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// SUN RGB-D: classes, the lines of VoteNet's extraction and the one place where its half sizes and
/// headings become boxes (docs/datasets/sunrgbd.md). open_dataset() reads whole folders. Points and
/// boxes are in the upright depth frame, which is `room`: x right, y forward, z up.

namespace arbox::io {

/// The 10 classes of the detection benchmark, in its order.
std::vector<std::string> sunrgbd_class_names();

/// One line of label/NAME.txt or label_v1/NAME.txt, in the file's own numbers.
struct SunRgbdLabel {
  std::string label;
  /// 2-D box: left, top, width, height, pixels.
  double left = 0.0, top = 0.0, width = 0.0, height = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  /// Half sizes: across the heading, along it, up.
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();
  /// Direction of the heading from above, of any length above zero.
  Eigen::Vector2d heading = Eigen::Vector2d::UnitX();
};

/// Reads lines `class left top width height cx cy cz c1 c2 c3 ox oy`. Half sizes may be negative in
/// the dataset's own annotations; their magnitude counts. Throws FormatError with file and line for
/// other counts of fields, numbers that are not finite, half sizes of zero and headings of zero.
std::vector<SunRgbdLabel> parse_sunrgbd_labels(std::string_view text, std::string_view source);

/// Such lines with nine decimals. Throws InvalidArgument for a class with blanks in it.
std::string format_sunrgbd_labels(std::span<const SunRgbdLabel> labels);

/// size = 2 (c2, c1, c3), yaw = atan2(oy, ox); the 2-D box becomes the attributes left top right
/// bottom.
LabeledObject to_object(const SunRgbdLabel& label);

/// The inverse of to_object for an upright box. Throws InvalidArgument for a tilted one.
SunRgbdLabel to_sunrgbd_label(const LabeledObject& object);

/// calib/NAME.txt: how the camera stood and what it saw.
struct SunRgbdCalibration {
  /// From the tilted depth frame of the camera to the upright one.
  Eigen::Matrix3d tilt = Eigen::Matrix3d::Identity();
  /// Pinhole matrix, pixels.
  Eigen::Matrix3d intrinsic = Eigen::Matrix3d::Identity();
};

/// Reads two lines of nine numbers, columns first. Throws FormatError for anything else, a first
/// line that is no rotation within 1e-3 and a singular second.
SunRgbdCalibration parse_sunrgbd_calibration(std::string_view text, std::string_view source);
std::string format_sunrgbd_calibration(const SunRgbdCalibration& calibration);

/// From the upright depth frame to pixels: K (x, -z, y) of tilt^T p.
Projection projection_of(const SunRgbdCalibration& calibration);

/// The calibration whose projection_of() that is, up to scale; nothing for a camera that does not
/// stand at the origin, or is none.
std::optional<SunRgbdCalibration> calibration_of(const Projection& projection);

/// One image of the toolbox' SUNRGBDMeta*.mat.
struct SunRgbdAnnotation {
  /// Number of the image, from 1.
  std::size_t number = 0;
  SunRgbdCalibration calibration;
  std::vector<LabeledObject> objects;
};

/// Reads the struct array SUNRGBDMeta (MATLAB 5 format) of the toolbox' annotations
/// (SUNRGBDMeta3DBB_v2.mat and its first version). Boxes are made of centroid, basis and
/// coefficients; the basis vector nearest to `orientation` is the heading. Boxes that are not valid
/// are left out, and so are elements without Rtilt and K. The sizes that the file claims are
/// compared with its bytes first. Throws IoError, FormatError.
std::vector<SunRgbdAnnotation> read_sunrgbd_toolbox(const std::filesystem::path& path);

/// Writes such a file with one element for each number from 1 to the largest; those without an
/// annotation stay empty. Boxes must stand upright. Throws InvalidArgument for tilted boxes and for
/// numbers that are 0, doubled or above 99999; IoError.
void write_sunrgbd_toolbox(const std::filesystem::path& path,
                           std::span<const SunRgbdAnnotation> annotations);

}  // namespace arbox::io
