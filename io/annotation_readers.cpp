#include <algorithm>
#include <array>
#include <map>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/io/annotation_tools.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"
#include "arbox/io/point_cloud_file.h"

// Folders of labelCloud and exports of CVAT behind DatasetReader.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kExportEndings = {".json", ".txt"};
constexpr std::array<std::string_view, 1> kCalibEndings = {".txt"};

std::map<std::string, fs::path> clouds_in(const Folder& folder) {
  std::map<std::string, fs::path> clouds;
  for (const fs::path& path : list_point_clouds(folder)) clouds.emplace(path.stem().string(), path);
  return clouds;
}

std::vector<std::string> keys_of(const std::map<std::string, fs::path>& clouds) {
  std::vector<std::string> names;
  for (const auto& [name, path] : clouds) names.push_back(name);
  return names;
}

class CloudFolder : public ListedDataset {
 public:
  SceneFrame frame() const override { return SceneFrame::kLidar; }
  std::vector<std::string> classes() const override { return {}; }

 protected:
  CloudFolder(const Folder& folder, const Folder& clouds)
      : ListedDataset(folder), clouds_(clouds_in(clouds)) {
    add_split(std::string(kAllScenes), keys_of(clouds_));
  }

  LabeledScene load_cloud(std::string_view split, std::string_view name) const {
    require_scene(split, name);
    LabeledScene scene{.name = std::string(name), .source = clouds_.at(std::string(name))};
    scene.cloud = read_point_cloud(scene.source).points;
    return scene;
  }

  const std::map<std::string, fs::path>& clouds() const { return clouds_; }

 private:
  std::map<std::string, fs::path> clouds_;
};

class LabelCloudReader : public CloudFolder {
 public:
  LabelCloudReader(const Folder& folder, const DatasetOptions& options)
      : CloudFolder(folder, folder / "pointclouds"), unit_(unit_of(folder, options)) {}

  std::string_view layout() const override { return "labelcloud"; }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    LabeledScene scene = load_cloud(split, name);
    const fs::path path = first_file(root() / "labels", name, kExportEndings);
    scene.labelled = !path.empty();
    if (!scene.labelled) return scene;
    const std::string text = read_file(path);
    if (path.extension() == ".json") {
      scene.objects = parse_labelcloud_json(text, path.string(), unit_).objects;
      return scene;
    }
    const fs::path calibration = first_file(root() / "calib", name, kCalibEndings);
    if (calibration.empty()) {
      scene.objects = parse_labelcloud_kitti(text, path.string());
      return scene;
    }
    scene.calibration = read_kitti_calibration(calibration);
    for (const auto& detection :
         to_detections(parse_kitti_labels(text, path.string()), *scene.calibration)) {
      // labelCloud's yaw of such files is half a turn from KITTI's.
      scene.objects.push_back(
          {.label = detection.label,
           .box = geometry::make_yaw_box(
               detection.box.center, detection.box.size,
               geometry::wrap_angle(geometry::yaw(detection.box) + std::numbers::pi))});
    }
    return scene;
  }

 private:
  /// Degrees as soon as one angle of the folder is more than a full turn in radians; degrees too if
  /// all angles are 0. Files whose angles are all small are in radians.
  static AngleUnit unit_of(const Folder& folder, const DatasetOptions& options) {
    if (!options.angles.empty()) {
      return options.angles == "degrees" ? AngleUnit::kDegrees : AngleUnit::kRadians;
    }
    double largest = 0.0;
    for (const std::string& name : names_in(folder / "labels", ".json")) {
      if (name.starts_with('_')) continue;
      const fs::path path = folder / "labels" / (name + ".json");
      try {
        largest = std::max(
            largest, parse_labelcloud_json(read_file(path), path.string(), AngleUnit::kRadians)
                         .largest_angle);
      } catch (const FormatError&) {
        // Told when the scan is loaded.
      }
    }
    const bool radians = largest > 0.0 && largest <= std::numbers::pi + 1e-6;
    return radians ? AngleUnit::kRadians : AngleUnit::kDegrees;
  }

  AngleUnit unit_;
};

Folder cvat_clouds(const Folder& root) {
  for (const char* folder : {"velodyne_points/data", "pointcloud", "points"}) {
    if (fs::is_directory(root / folder)) return root / folder;
  }
  return root;
}

class CvatReader : public CloudFolder {
 public:
  explicit CvatReader(const Folder& folder) : CloudFolder(folder, cvat_clouds(folder)) {
    const fs::path path = folder / "tracklet_labels.xml";
    const Tracklets tracklets = parse_cvat_tracklets(read_file(path), path.string());
    const auto names = frame_names();
    for (const auto& [frame, objects] : tracklets) {
      const auto name = names.find(frame);
      if (name == names.end() || !clouds().contains(name->second)) {
        problems_.push_back(path.string() + ": labels of frame " + std::to_string(frame) +
                            ", which has no cloud");
        continue;
      }
      objects_[name->second] = objects;
    }
  }

  std::string_view layout() const override { return "cvat"; }
  std::vector<std::string> problems() const override { return problems_; }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    LabeledScene scene = load_cloud(split, name);
    const auto found = objects_.find(scene.name);
    if (found != objects_.end()) scene.objects = found->second;
    return scene;
  }

 private:
  /// frame_list.txt: "NUMBER NAME" lines; without it frames are the clouds in order of their names.
  std::map<std::int64_t, std::string> frame_names() const {
    std::map<std::int64_t, std::string> names;
    const fs::path list = root() / "frame_list.txt";
    if (!fs::exists(list)) {
      for (const auto& [name, path] : clouds()) {
        names.emplace(static_cast<std::int64_t>(names.size()), name);
      }
      return names;
    }
    const std::string source = list.string(), text = read_file(list);
    LineReader lines(text, source);
    while (lines.next_filled()) {
      const auto fields = split_white_space(lines.line());
      if (fields.size() < 2) refuse(lines.place(), "a frame's number and name", "one word");
      const std::string_view rest = trimmed(lines.line()).substr(fields[0].size());
      names[parse_integer(fields[0], "number", lines.place())] =
          fs::path(trimmed(rest)).filename().stem().string();
    }
    return names;
  }

  std::map<std::string, std::vector<LabeledObject>> objects_;
  std::vector<std::string> problems_;
};

}  // namespace

bool fits_labelcloud(const Folder& root) {
  return fs::is_directory(root / "pointclouds") && fs::is_directory(root / "labels");
}

bool fits_cvat(const Folder& root) { return fs::exists(root / "tracklet_labels.xml"); }

Reader open_labelcloud(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<LabelCloudReader>(root, options);
}

Reader open_cvat(const Folder& root, const DatasetOptions&) {
  return std::make_unique<CvatReader>(root);
}

}  // namespace arbox::io::internal
