#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/kitti_dataset.h"

namespace arbox::io {

/// What was found of one kind of file (`velodyne`, `label_2`, `calib`, `image_2`, `planes`).
struct KittiFileReport {
  std::string kind;
  /// Whether a frame of the split cannot be used without it.
  bool required = true;
  std::int64_t present = 0;
  /// Frames that lack it.
  std::vector<std::string> missing;
  /// One message a broken file: path, first bad line, what was expected and what came.
  std::vector<std::string> broken;
};

struct KittiSplitReport {
  std::string split;
  /// `training` or `testing`.
  std::string folder;
  /// What is wrong with the split's own file; empty if nothing is.
  std::string problem;
  std::int64_t frames = 0;
  /// Labelled objects of each class, DontCare included.
  std::map<std::string, std::int64_t> objects;
  /// In the order velodyne, label_2 (training only), calib, image_2, planes.
  std::vector<KittiFileReport> files;
};

/// Reads every label, calibration and plane of a split and looks at the size of its scans and at
/// the header of its images; point values are not read. Never throws for what is in the files: that
/// is the report. `done` is called once a frame, from any thread. threads = 0 means
/// default_threads(); the report does not depend on it.
KittiSplitReport check_kitti_split(const KittiDataset& dataset, std::string_view split,
                                   int threads = 0, const std::function<void()>& done = {});

}  // namespace arbox::io
