#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"
#include "arbox/io/pickle.h"

/// \file
/// The `*_infos_*.pkl` of mmdetection3d for ScanNet and SUN RGB-D, of both generations: lists of
/// dictionaries with NumPy arrays (before 1.1) and dictionaries of plain lists (from 1.1 on). Read
/// by a reader that runs nothing (io/pickle.h).

namespace arbox::io {

/// Which way yaw runs in a file of SUN RGB-D.
enum class YawSense { kClockwise, kCounterClockwise };

/// One scan of an infos file, in the file's own frame and with its own yaw.
struct Mmdet3dInfo {
  /// The stem of the points' file.
  std::string name;
  /// As written: "points/scene0000_00.bin", or the file's name alone in the newer form.
  std::string points;
  std::size_t columns = 6;
  /// From the points' frame to the boxes'; identity if there is none.
  Eigen::Matrix4d alignment = Eigen::Matrix4d::Identity();
  bool labelled = false;
  std::vector<std::string> labels;
  /// Centre, full sizes, yaw (0 where the file has six numbers).
  std::vector<std::array<double, 7>> boxes;
  /// left top right bottom, pixels; as many as boxes, or none.
  std::vector<std::array<double, 4>> image_boxes;
  std::string image;
  std::optional<Projection> projection;
  /// What the order of the key `dimensions` says of the writer's version, or the key `yaw` of the
  /// metainfo that Arbox writes; nothing if they are not there or say nothing.
  std::optional<YawSense> written_sense;
};

/// Reads an infos file. Throws FormatError with the place in the pickle.
std::vector<Mmdet3dInfo> read_mmdet3d_infos(const PickleValue& root);

/// Finds out which way yaw runs: the boxes, projected into their images under either sense, are
/// compared with the 2-D boxes; where there are too few of these, written_sense tells (the order of
/// `dimensions` is length, height, width before 1.0). Nothing if neither does.
std::optional<YawSense> find_yaw_sense(const std::vector<Mmdet3dInfo>& infos);

}  // namespace arbox::io
