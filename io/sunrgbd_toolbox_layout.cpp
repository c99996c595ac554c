#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <set>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/sunrgbd_files.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/sunrgbd.h"

// The toolbox' annotations of SUN RGB-D behind DatasetReader and DatasetWriter, with the clouds and
// photos of VoteNet's extraction beside them.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kMetaFiles = {"SUNRGBDMeta3DBB_v2.mat",
                                                        "SUNRGBDMeta3DBB.mat"};
constexpr const char* kListEnding = "_data_idx.txt";
constexpr std::size_t kMostDigits = 5;

fs::path meta_file(const Folder& root) {
  const std::array<std::string_view, 1> as_it_is = {""};
  for (const std::string_view name : kMetaFiles) {
    const fs::path path = first_file(root, name, as_it_is);
    if (!path.empty()) return path;
  }
  return {};
}

class ToolboxReader : public ListedDataset {
 public:
  ToolboxReader(const Folder& folder, const DatasetOptions& options)
      : ListedDataset(folder), all_classes_(options.classes == "all") {
    source_ = meta_file(folder);
    if (source_.empty()) {
      throw IoError(folder.string() + ": expected SUNRGBDMeta3DBB_v2.mat of the toolbox");
    }
    std::vector<std::string> all;
    for (SunRgbdAnnotation& annotation : read_sunrgbd_toolbox(source_)) {
      all.push_back(sunrgbd_scene_name(std::to_string(annotation.number)));
      annotations_.emplace(all.back(), std::move(annotation));
    }
    for (const std::string& split : names_in(folder, kListEnding)) {
      std::vector<std::string> names = read_kitti_split(folder / (split + kListEnding));
      std::transform(names.begin(), names.end(), names.begin(), sunrgbd_scene_name);
      add_split(split, std::move(names));
    }
    add_split(std::string(kAllScenes), std::move(all));
  }

  std::string_view layout() const override { return "sunrgbd-toolbox"; }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override {
    return all_classes_ ? std::vector<std::string>{} : sunrgbd_class_names();
  }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    require_scene(split, name);
    const auto found = annotations_.find(std::string(name));
    if (found == annotations_.end()) {
      throw FormatError(source_.string() + ": holds no image " + std::string(name));
    }
    const SunRgbdAnnotation& annotation = found->second;
    LabeledScene scene{.name = std::string(name), .source = source_, .frame = SceneFrame::kRoom};
    const auto known = sunrgbd_class_names();
    for (const LabeledObject& object : annotation.objects) {
      if (all_classes_ || std::find(known.begin(), known.end(), object.label) != known.end()) {
        scene.objects.push_back(object);
      }
    }
    const fs::path depth = root() / "depth" / (scene.name + ".mat");
    if (fs::exists(depth)) {
      scene.cloud = read_sunrgbd_depth(depth);
      scene.source = depth;
    }
    const fs::path image = first_file(root() / "image", scene.name, kSunRgbdImages);
    if (!image.empty()) {
      scene.photo = {.path = image, .projection = projection_of(annotation.calibration)};
    }
    return scene;
  }

 private:
  bool all_classes_;
  fs::path source_;
  std::map<std::string, SunRgbdAnnotation> annotations_;
};

/// A camera at the origin that looks along y, for scenes without one.
SunRgbdCalibration nominal_camera() {
  SunRgbdCalibration calibration;
  calibration.intrinsic << 529.5, 0, 365, 0, 529.5, 265, 0, 0, 1;
  return calibration;
}

class ToolboxWriter : public AccountingWriter {
 public:
  explicit ToolboxWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kRoom, .boxes = BoxForm::kUpright}) {
    make_folder(root() / "depth");
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    SunRgbdAnnotation annotation{.number = 0, .calibration = nominal_camera(), .objects = {}};
    annotation.objects = scene.objects;
    if (!scene.labelled) note("scans without labels became scans with no objects");
    std::vector<fs::path> files = {root() / "depth" / ("." + scene.name + ".mat")};
    write_sunrgbd_depth(files[0], scene.cloud);
    std::optional<SunRgbdCalibration> seen;
    if (scene.photo) seen = calibration_of(scene.photo->projection);
    if (seen) {
      annotation.calibration = *seen;
      make_folder(root() / "image");
      files.push_back(root() / "image" /
                      ("." + scene.name + scene.photo->path.extension().string()));
      write_file(files[1], read_file(scene.photo->path));
    }
    const std::scoped_lock lock(mutex_);
    annotations_.emplace(scene.name, std::move(annotation));
    files_.emplace(scene.name, std::move(files));
  }

  /// The scenes' own numbers if they all have one, else their places in the order of their names.
  std::map<std::string, std::size_t> numbers() const {
    std::map<std::string, std::size_t> own, counted;
    std::set<std::size_t> seen;
    for (const auto& [name, annotation] : annotations_) {
      counted.emplace(name, counted.size() + 1);
      const std::size_t first = std::min(name.find_first_not_of('0'), name.size());
      const bool short_number =
          is_image_number(name) && first < name.size() && name.size() - first <= kMostDigits;
      if (short_number && seen.insert(std::stoul(name)).second) own.emplace(name, std::stoul(name));
    }
    return own.size() == counted.size() ? own : counted;
  }

  void write_rest() override {
    const auto number_of = numbers();
    std::vector<SunRgbdAnnotation> annotations;
    for (auto& [name, annotation] : annotations_) {
      annotation.number = number_of.at(name);
      const std::string final_name = sunrgbd_scene_name(std::to_string(annotation.number));
      if (final_name != name) note("scenes got a number in place of their name");
      for (const fs::path& file : files_.at(name)) {
        std::error_code error;
        fs::rename(file, file.parent_path() / (final_name + file.extension().string()), error);
        if (error) throw IoError(file.string() + ": cannot be renamed: " + error.message());
      }
      annotations.push_back(std::move(annotation));
    }
    write_sunrgbd_toolbox(root() / kMetaFiles[0], annotations);
    for (const auto& [split, names] : lists()) {
      std::string text;
      for (const std::string& name : names) {
        text += sunrgbd_scene_name(std::to_string(number_of.at(name))) + "\n";
      }
      write_file(root() / (split + kListEnding), text);
    }
  }

  std::mutex mutex_;
  std::map<std::string, SunRgbdAnnotation> annotations_;
  std::map<std::string, std::vector<fs::path>> files_;
};

}  // namespace

bool fits_sunrgbd_toolbox(const Folder& root) { return !meta_file(root).empty(); }

Reader open_sunrgbd_toolbox(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<ToolboxReader>(root, options);
}

Writer create_sunrgbd_toolbox(const NewDataset& dataset) {
  return std::make_unique<ToolboxWriter>(dataset.root);
}

}  // namespace arbox::io::internal
