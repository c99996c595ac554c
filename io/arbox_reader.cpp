#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "arbox/base/error.h"
#include "arbox/io/arbox_dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/label_file.h"
#include "arbox/io/point_cloud_file.h"

// Arbox' own layout behind DatasetReader and DatasetWriter.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

using Files = std::map<std::string, fs::path>;

constexpr std::array<std::string_view, 2> kLabelEndings = {".json", ".txt"};
constexpr std::array<std::string_view, 6> kImageEndings = {".png", ".jpg", ".jpeg",
                                                           ".PNG", ".JPG", ".JPEG"};

/// Clouds of a folder by name.
Files list_clouds(const Folder& folder, std::vector<std::string>& problems) {
  Files files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& path = entry->path();
    if (!format_of_extension(path) || path.filename().string().front() == '.') continue;
    const auto [place, added] = files.emplace(path.stem().string(), path);
    if (added) continue;
    problems.push_back(path.string() + ": a second cloud of the name of " + place->second.string() +
                       "; remove one");
    place->second = std::min(place->second, path);
  }
  return files;
}

class ArboxReader : public ListedDataset {
 public:
  explicit ArboxReader(const Folder& root) : ListedDataset(root) {
    if (fs::exists(root / "dataset.json")) {
      const fs::path path = root / "dataset.json";
      description_ = parse_dataset_description(read_file(path), path.string());
    }
    if (!fs::is_directory(root / "points")) {
      throw IoError(root.string() + ": expected a folder points with the clouds; `arbox init " +
                    root.string() + "` makes one");
    }
    clouds_ = list_clouds(root / "points", problems_);
    std::vector<std::string> all;
    for (const auto& [name, path] : clouds_) all.push_back(name);
    add_listed_splits(all);
    for (const std::string_view ending : kLabelEndings) {
      for (const std::string& name : names_in(root / "labels", ending)) {
        if (!clouds_.contains(name)) {
          problems_.push_back((root / "labels" / (name + std::string(ending))).string() +
                              ": labels without a cloud points/" + name + ".*");
        }
      }
    }
    add_split(std::string(kAllScenes), std::move(all));
  }

  std::string_view layout() const override { return "arbox"; }
  SceneFrame frame() const override { return description_.frame; }
  std::vector<std::string> classes() const override { return description_.classes; }
  std::vector<std::string> problems() const override { return problems_; }

  LabeledScene load(std::string_view, std::string_view name) const override {
    const auto cloud = clouds_.find(std::string(name));
    if (cloud == clouds_.end()) {
      throw IoError(root().string() + ": no cloud points/" + std::string(name) + ".*");
    }
    LabeledScene scene{
        .name = std::string(name), .source = cloud->second, .frame = description_.frame};
    scene.cloud = read_point_cloud(cloud->second, {.channels = columns_of(cloud->second)}).points;
    read_labels(scene);
    read_camera(scene);
    return scene;
  }

 private:
  void add_listed_splits(const std::vector<std::string>& all) {
    for (const std::string& split : names_in(root() / "splits", ".txt")) {
      std::vector<std::string> names = read_kitti_split(root() / "splits" / (split + ".txt"));
      for (const std::string& name : names) {
        if (!std::binary_search(all.begin(), all.end(), name)) {
          problems_.push_back((root() / "splits" / (split + ".txt")).string() + ": lists " +
                              quoted_text(name) + ", which has no cloud");
        }
      }
      if (split != kAllScenes) add_split(split, std::move(names));
    }
  }

  std::vector<std::string> columns_of(const fs::path& path) const {
    return path.extension() == ".bin" ? description_.columns : std::vector<std::string>{};
  }

  void read_labels(LabeledScene& scene) const {
    const fs::path path = first_file(root() / "labels", scene.name, kLabelEndings);
    scene.labelled = !path.empty();
    if (!scene.labelled) return;
    LabelFile file = read_label_file(path);
    if (file.frame && *file.frame != description_.frame) {
      throw FormatError(path.string() + ": expected labels in the dataset's frame " +
                        std::string(name_of(description_.frame)) + ", got frame " +
                        std::string(name_of(*file.frame)));
    }
    for (LabeledObject& object : file.objects) {
      const auto mapped = description_.class_map.find(object.label);
      if (mapped != description_.class_map.end()) {
        if (!mapped->second) continue;
        object.label = *mapped->second;
      }
      require_known_class(object, path);
      scene.objects.push_back(std::move(object));
    }
  }

  void require_known_class(const LabeledObject& object, const fs::path& path) const {
    const auto& classes = description_.classes;
    if (classes.empty() ||
        std::find(classes.begin(), classes.end(), object.label) != classes.end()) {
      return;
    }
    throw FormatError(path.string() + ": expected one of the classes " + joined(classes, ", ") +
                      ", got " + quoted_text(object.label) +
                      "; add it to classes or class_map in dataset.json");
  }

  void read_camera(LabeledScene& scene) const {
    fs::path path = first_file(root() / "calib", scene.name, kLabelEndings);
    if (path.empty()) path = first_file(root(), "calib", kLabelEndings);
    const fs::path image = first_file(root() / "images", scene.name, kImageEndings);
    if (path.empty()) return;
    ScenePhoto photo{.path = image};
    if (path.extension() == ".json") {
      const CameraFile camera = parse_camera_json(read_file(path), path.string());
      photo.projection = camera.projection;
      photo.size = camera.size;
    } else {
      scene.calibration = read_kitti_calibration(path);
      photo.projection = image_from_lidar(*scene.calibration);
    }
    if (!image.empty()) scene.photo = std::move(photo);
  }

  DatasetDescription description_;
  Files clouds_;
  std::vector<std::string> problems_;
};

class ArboxWriter : public AccountingWriter {
 public:
  explicit ArboxWriter(const NewDataset& dataset)
      : AccountingWriter(dataset.root, {.frame = dataset.frame}) {
    make_folder(root() / "points");
    make_folder(root() / "labels");
    write_file(root() / "dataset.json",
               format_dataset_description({.frame = dataset.frame, .classes = dataset.classes}));
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    write_point_cloud(root() / "points" / (scene.name + ".pcd"), scene.cloud.view());
    if (scene.labelled) {
      write_file(root() / "labels" / (scene.name + ".json"),
                 format_label_json(scene.objects, scene.frame));
    }
    if (scene.photo) write_photo(scene);
  }

  void write_photo(const LabeledScene& scene) const {
    make_folder(root() / "images");
    make_folder(root() / "calib");
    write_file(root() / "images" / (scene.name + scene.photo->path.extension().string()),
               read_file(scene.photo->path));
    write_file(root() / "calib" / (scene.name + (scene.calibration ? ".txt" : ".json")),
               scene.calibration
                   ? format_kitti_calibration(*scene.calibration)
                   : format_camera_json({scene.photo->projection, scene.photo->size}));
  }

  void write_rest() override {
    make_folder(root() / "splits");
    write_lists(root() / "splits", "", ".txt");
  }
};

}  // namespace

bool fits_arbox(const Folder& root) {
  return fs::exists(root / "dataset.json") ||
         (fs::is_directory(root / "points") && fs::is_directory(root / "labels"));
}

Reader open_arbox(const Folder& root, const DatasetOptions&) {
  return std::make_unique<ArboxReader>(root);
}

Writer create_arbox(const NewDataset& dataset) { return std::make_unique<ArboxWriter>(dataset); }

}  // namespace arbox::io::internal
