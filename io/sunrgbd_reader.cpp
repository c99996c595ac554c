#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/colored_rows.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/mat_file.h"
#include "arbox/io/internal/sunrgbd_files.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/sunrgbd.h"

// VoteNet's extraction of SUN RGB-D (sunrgbd_trainval) behind DatasetReader and DatasetWriter.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCloudVariable = "instance";

class SunRgbdReader : public ListedDataset {
 public:
  SunRgbdReader(const Folder& folder, const DatasetOptions& options)
      : ListedDataset(folder),
        labels_(options.sunrgbd_labels == "v1" ? "label_v1" : "label"),
        all_classes_(options.classes == "all") {
    for (const std::string& split : names_in(folder, "_data_idx.txt")) {
      std::vector<std::string> names = read_kitti_split(folder / (split + "_data_idx.txt"));
      std::transform(names.begin(), names.end(), names.begin(), sunrgbd_scene_name);
      add_split(split, std::move(names));
    }
    add_split(std::string(kAllScenes), names_in(folder / "depth", ".mat"));
  }

  std::string_view layout() const override { return "sunrgbd"; }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override {
    return all_classes_ ? std::vector<std::string>{} : sunrgbd_class_names();
  }

  LabeledScene load(std::string_view, std::string_view name) const override {
    LabeledScene scene{.name = std::string(name), .frame = SceneFrame::kRoom};
    scene.source = root() / "depth" / (scene.name + ".mat");
    scene.cloud = read_sunrgbd_depth(scene.source);
    read_labels(scene);
    read_photo(scene);
    return scene;
  }

 private:
  void read_labels(LabeledScene& scene) const {
    const fs::path path = root() / labels_ / (scene.name + ".txt");
    scene.labelled = fs::exists(path);
    if (!scene.labelled) return;
    const auto known = sunrgbd_class_names();
    for (const SunRgbdLabel& label : parse_sunrgbd_labels(read_file(path), path.string())) {
      if (all_classes_ || std::find(known.begin(), known.end(), label.label) != known.end()) {
        scene.objects.push_back(to_object(label));
      }
    }
  }

  void read_photo(LabeledScene& scene) const {
    const fs::path calibration = root() / "calib" / (scene.name + ".txt");
    const fs::path image = first_file(root() / "image", scene.name, kSunRgbdImages);
    if (image.empty() || !fs::exists(calibration)) return;
    scene.photo = {.path = image,
                   .projection = projection_of(
                       parse_sunrgbd_calibration(read_file(calibration), calibration.string()))};
  }

  std::string labels_;
  bool all_classes_;
};

class SunRgbdWriter : public AccountingWriter {
 public:
  explicit SunRgbdWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kRoom, .boxes = BoxForm::kUpright}) {
    for (const char* part : {"depth", "label", "calib"}) make_folder(root() / part);
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    const auto file = [&](const char* part, const std::string& ending) {
      return root() / part / (scene.name + ending);
    };
    write_sunrgbd_depth(file("depth", ".mat"), scene.cloud);
    if (scene.labelled) {
      std::vector<SunRgbdLabel> labels;
      for (const LabeledObject& object : scene.objects) labels.push_back(to_sunrgbd_label(object));
      write_file(file("label", ".txt"), format_sunrgbd_labels(labels));
    }
    std::optional<SunRgbdCalibration> calibration;
    if (scene.photo) calibration = calibration_of(scene.photo->projection);
    if (!calibration) return;
    write_file(file("calib", ".txt"), format_sunrgbd_calibration(*calibration));
    make_folder(root() / "image");
    write_file(file("image", scene.photo->path.extension().string()), read_file(scene.photo->path));
  }

  void write_rest() override { write_lists(root(), "", "_data_idx.txt"); }
};

}  // namespace

geometry::PointCloud read_sunrgbd_depth(const fs::path& path) {
  MatMatrix matrix = read_mat_matrix(path, kCloudVariable);
  if (matrix.columns != 6 && matrix.columns != 3) {
    throw FormatError(path.string() + ": expected rows x y z r g b, got " +
                      std::to_string(matrix.columns) + " columns");
  }
  return colored_cloud(std::move(matrix.values), matrix.columns);
}

void write_sunrgbd_depth(const fs::path& path, const geometry::PointCloud& cloud) {
  write_mat_matrix(path, kCloudVariable, {cloud.size(), 6, colored_rows(cloud, 1.0F)});
}

bool fits_sunrgbd(const Folder& root) {
  return fs::is_directory(root / "depth") &&
         (fs::is_directory(root / "label") || fs::is_directory(root / "label_v1"));
}

Reader open_sunrgbd(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<SunRgbdReader>(root, options);
}

Writer create_sunrgbd(const NewDataset& dataset) {
  return std::make_unique<SunRgbdWriter>(dataset.root);
}

}  // namespace arbox::io::internal
