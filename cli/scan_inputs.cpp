#include "arbox/cli/scan_inputs.h"

#include "arbox/base/names.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/standard_input.h"
#include "arbox/io/kitti_dataset.h"

namespace arbox::cli {
namespace {

bool is_kitti_root(const std::string& path) {
  try {
    io::KittiDataset::open(path);
    return true;
  } catch (const IoError&) {
    return false;
  }
}

void add_frames(const std::string& root, const std::string& split, std::vector<ScanInput>& scans) {
  if (!is_kitti_root(root)) {
    throw UsageError(
        "--split: expected the root of a KITTI dataset (a folder with training or "
        "testing in it), got " +
        root);
  }
  const io::KittiDataset dataset = io::KittiDataset::open(root);
  std::vector<std::string> frames;
  try {
    frames = dataset.frames(split);
  } catch (const InvalidArgument& error) {
    throw UsageError(std::string("--split: ") + error.what());
  }
  if (frames.empty()) throw IoError(root + ": the split '" + split + "' has no frames");
  for (const std::string& frame : frames) {
    const io::KittiPaths paths = dataset.paths(split, frame);
    scans.push_back({paths.scan.string(), paths.calibration, paths.image});
  }
}

void add_folder(const std::string& folder, std::vector<ScanInput>& scans) {
  const auto files = io::list_point_clouds(folder);
  if (files.empty() && is_kitti_root(folder)) {
    throw UsageError(folder + ": is the root of a KITTI dataset, whose splits are " +
                     join(io::KittiDataset::open(folder).splits(), ", ") +
                     "; name one of them with --split");
  }
  if (files.empty()) throw IoError(folder + ": holds no point clouds");
  for (const auto& file : files) scans.push_back({file.string()});
}

}  // namespace

std::vector<ScanInput> list_scans(const std::vector<std::string>& inputs, const std::string& split,
                                  const std::function<void(const Error&)>& on_failure) {
  std::vector<ScanInput> scans;
  for (const std::string& input : inputs) {
    try {
      if (!split.empty()) {
        add_frames(input, split, scans);
      } else if (std::filesystem::is_directory(input)) {
        add_folder(input, scans);
      } else {
        scans.push_back({input});
      }
    } catch (const IoError& error) {
      if (inputs.size() == 1) throw;
      on_failure(error);
    }
  }
  return scans;
}

io::PointCloudFile read_scan(const ScanInput& scan, io::ReadOptions options) {
  if (scan.is_kitti_frame()) {
    if (options.channels.empty()) options.channels = {"x", "y", "z", "intensity"};
    if (options.format.empty()) options.format = "bin";
  }
  return read_point_cloud_input(scan.source, options);
}

}  // namespace arbox::cli
