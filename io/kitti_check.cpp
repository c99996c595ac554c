#include "arbox/io/kitti_check.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/io/kitti_label.h"

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

struct Finding {
  bool present = false;
  std::string problem;
};

enum FileKind { kScan, kLabel, kCalibration, kImage, kPlane };

struct FrameFindings {
  std::array<Finding, 5> files;
  std::map<std::string, std::int64_t> objects;
};

template <class Read>
Finding check_file(const fs::path& path, const Read& read) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  try {
    read(path);
  } catch (const Error& error) {
    return {.present = true, .problem = error.what()};
  }
  return {.present = true, .problem = {}};
}

FrameFindings check_frame(const KittiPaths& paths, bool labelled) {
  FrameFindings findings;
  findings.files[kScan] =
      check_file(paths.scan, [](const fs::path& path) { count_kitti_points(path); });
  findings.files[kCalibration] =
      check_file(paths.calibration, [](const fs::path& path) { read_kitti_calibration(path); });
  findings.files[kImage] =
      check_file(paths.image, [](const fs::path& path) { read_png_size(path); });
  findings.files[kPlane] =
      check_file(paths.plane, [](const fs::path& path) { read_kitti_plane(path); });
  if (labelled) {
    findings.files[kLabel] = check_file(paths.label, [&](const fs::path& path) {
      for (const KittiObject& object : read_kitti_labels(path)) ++findings.objects[object.type];
    });
  }
  return findings;
}

void add(const Finding& finding, const std::string& id, KittiFileReport& report) {
  report.present += finding.present ? 1 : 0;
  if (!finding.present) report.missing.push_back(id);
  if (!finding.problem.empty()) report.broken.push_back(finding.problem);
}

}  // namespace

KittiSplitReport check_kitti_split(const KittiDataset& dataset, std::string_view split, int threads,
                                   const std::function<void()>& done) {
  KittiSplitReport report;
  report.split = split;
  report.folder = KittiDataset::folder(split);
  std::vector<std::string> ids;
  try {
    ids = dataset.frames(split);
  } catch (const FormatError& error) {
    report.problem = error.what();
    return report;
  }
  const bool labelled = report.folder == "training";
  std::vector<FrameFindings> findings(ids.size());
  parallel_for(static_cast<std::int64_t>(ids.size()), 16, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   findings[i] = check_frame(dataset.paths(split, ids[i]), labelled);
                   if (done) done();
                 }
               });
  report.frames = static_cast<std::int64_t>(ids.size());
  static constexpr std::array<std::pair<const char*, bool>, 5> kKinds = {{{"velodyne", true},
                                                                          {"label_2", true},
                                                                          {"calib", true},
                                                                          {"image_2", false},
                                                                          {"planes", false}}};
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    if (kind == kLabel && !labelled) continue;
    KittiFileReport& files = report.files.emplace_back();
    files.kind = kKinds[kind].first;
    files.required = kKinds[kind].second;
    for (std::size_t i = 0; i < ids.size(); ++i) add(findings[i].files[kind], ids[i], files);
  }
  for (const FrameFindings& frame : findings) {
    for (const auto& [type, count] : frame.objects) report.objects[type] += count;
  }
  return report;
}

}  // namespace arbox::io
