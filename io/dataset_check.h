#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/dataset.h"

/// \file
/// What usually goes wrong with labels, found by looking at the points (docs/datasets/own.md,
/// "Checking").
///
/// A box fits an object if the points close to it lie inside and fill it. Each box is tried as it
/// is and under every mistake that people make: half and double sizes, length and width swapped,
/// yaw of the other sense, in degrees, another frame, the centre of the bottom face. A mistake is
/// reported if undoing it makes clearly more boxes fit than it spoils. Scenes in the frame
/// `camera`, where nothing says what is below, are not tried so; all else is checked there, too.

namespace arbox::io {

struct DatasetFinding {
  /// "broken", "empty scan", "box without points", "half sizes", "double sizes", "swapped sizes",
  /// "yaw sense", "degrees", "frame", "bottom centre", "unit", "large box", "doubled box",
  /// "folder".
  std::string kind;
  /// What it is and how often.
  std::string text;
  /// How to mend it; empty if that is plain.
  std::string mend;
  std::size_t count = 0;
  /// The first few places.
  std::vector<std::string> examples;
};

struct ClassSummary {
  std::size_t objects = 0, without_points = 0;
  Eigen::Vector3d mean_size = Eigen::Vector3d::Zero();
};

struct DatasetCheck {
  std::string layout, split;
  std::size_t scenes = 0, labelled = 0, objects = 0;
  std::uint64_t points = 0;
  std::map<std::string, ClassSummary> classes;
  /// Worst first; empty if nothing was found.
  std::vector<DatasetFinding> findings;
};

/// Reads every scene of a split. Never throws for what is in the files: that is the report. `done`
/// is called once a scene, from any thread. threads = 0 means four for each of default_threads(),
/// so that some wait for the disk while others work; the report does not depend on it. Memory: one
/// scene a thread. Mistakes are weighed in up to 800 scans spread over the split; everything else
/// is looked at in all.
DatasetCheck check_dataset(const DatasetReader& dataset, std::string_view split, int threads = 0,
                           const std::function<void()>& done = {});

}  // namespace arbox::io
