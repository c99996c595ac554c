#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "arbox/evaluation/kitti_protocol.h"

namespace arbox::evaluation {

struct KittiFrames {
  /// File names without ".txt", in the order of `frames`.
  std::vector<std::string> names;
  std::vector<KittiFrame> frames;
};

/// The frames to score: those that `split` lists, one name a line; without it, those that have a
/// result file, sorted by name, as in the official kit. Throws IoError for a missing folder or
/// file, FormatError for a split that names nothing or a frame twice.
std::vector<std::string> kitti_frame_names(const std::filesystem::path& predictions,
                                           const std::optional<std::filesystem::path>& split = {});

/// Reads the labels LABELS/NAME.txt and results PREDICTIONS/NAME.txt of many frames, in parallel.
///
/// The frames are those of kitti_frame_names. As in the official kit, an empty result file is a
/// frame in which nothing was found, while a frame without a result file is an error: a missing
/// file more often tells of a run that broke off.
///
/// Throws IoError that names the missing folder or file, FormatError for lines that
/// io/kitti_label.h refuses and for a bad split. Of several bad files the first frame's is
/// reported. threads = 0 means default_threads(). `read` is called once a frame, from any thread.
KittiFrames read_kitti_frames(const std::filesystem::path& labels,
                              const std::filesystem::path& predictions,
                              const std::optional<std::filesystem::path>& split = {},
                              int threads = 0, const std::function<void()>& read = {});

}  // namespace arbox::evaluation
