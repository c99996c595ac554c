#include <algorithm>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/kitti_label.h"
#include "arbox/io/point_cloud_file.h"

// KITTI's object layout behind DatasetReader and DatasetWriter.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTrainingFolder = "training";
constexpr int kKittiDecimals = 4;

LabeledObject to_object(const KittiObject& object, const KittiCalibration& calibration) {
  return {.label = object.type,
          .box = to_box(object, calibration),
          .heading = Heading::kKnown,
          .attributes = {{"truncation", object.truncation},
                         {"occlusion", object.occlusion},
                         {"alpha", object.alpha},
                         {"left", object.left},
                         {"top", object.top},
                         {"right", object.right},
                         {"bottom", object.bottom}}};
}

class KittiReader : public DatasetReader {
 public:
  explicit KittiReader(const Folder& root) : dataset_(KittiDataset::open(root)) {}

  std::string_view layout() const override { return "kitti"; }
  SceneFrame frame() const override { return SceneFrame::kLidar; }
  std::vector<std::string> classes() const override { return {}; }

  std::vector<std::string> splits() const override {
    auto names = dataset_.splits();
    // Last, so that it is the one with every labelled frame.
    const auto training = std::find(names.begin(), names.end(), kTrainingFolder);
    if (training != names.end()) std::rotate(training, training + 1, names.end());
    return names;
  }

  std::vector<std::string> names(std::string_view split) const override {
    return dataset_.frames(split);
  }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    KittiFrame frame = dataset_.load(split, name);
    LabeledScene scene{.name = std::string(name),
                       .source = dataset_.paths(split, name).scan,
                       .frame = SceneFrame::kLidar,
                       .cloud = std::move(frame.cloud)};
    scene.labelled = KittiDataset::folder(split) == kTrainingFolder;
    for (const KittiObject& object : frame.labels) {
      if (has_box(object)) scene.objects.push_back(to_object(object, frame.calibration));
    }
    if (!frame.image.empty()) {
      scene.photo = {.path = frame.image,
                     .size = frame.image_size.value_or(ImageSize{}),
                     .projection = image_from_lidar(frame.calibration)};
    }
    scene.calibration = frame.calibration;
    return scene;
  }

 private:
  KittiDataset dataset_;
};

double attribute(const LabeledObject& object, const char* name, double otherwise) {
  const auto found = object.attributes.find(name);
  return found == object.attributes.end() ? otherwise : found->second;
}

/// A camera in the place of the LiDAR that looks forward, for scans that came without one.
KittiCalibration forward_camera() {
  KittiCalibration calibration;
  calibration.projections.fill(Projection::Zero());
  for (auto& projection : calibration.projections) {
    *projection << 721.5377, 0, 609.5593, 0, 0, 721.5377, 172.854, 0, 0, 0, 1, 0;
  }
  calibration.velodyne_to_camera.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return calibration;
}

KittiObject to_label(const LabeledObject& labeled, const KittiCalibration& calibration,
                     const ImageSize& image, bool of_this_image) {
  KittiObject object = to_kitti_object(labeled.box, calibration);
  object.type = labeled.label;
  std::replace_if(
      object.type.begin(), object.type.end(), [](unsigned char letter) { return letter <= ' '; },
      '_');
  object.truncation = std::clamp(attribute(labeled, "truncation", 0.0), 0.0, 1.0);
  object.occlusion =
      static_cast<int>(std::clamp(std::round(attribute(labeled, "occlusion", 0.0)), 0.0, 3.0));
  object.alpha = observation_angle(object);
  if (const auto box = projected_box(object, calibration)) {
    const auto shown = clipped(*box, image);
    if (shown) {
      object.left = shown->left, object.top = shown->top;
      object.right = shown->right, object.bottom = shown->bottom;
    }
  }
  if (!of_this_image) return object;
  object.left = attribute(labeled, "left", object.left);
  object.top = attribute(labeled, "top", object.top);
  object.right = attribute(labeled, "right", object.right);
  object.bottom = attribute(labeled, "bottom", object.bottom);
  return object;
}

class KittiWriter : public AccountingWriter {
 public:
  explicit KittiWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kLidar, .boxes = BoxForm::kUpright}) {
    for (const char* part : {"velodyne", "label_2", "calib"}) {
      make_folder(root() / kTrainingFolder / part);
    }
    make_folder(root() / "ImageSets");
  }

 private:
  void write(const std::string& split, const LabeledScene& scene) override {
    const KittiCalibration calibration = scene.calibration.value_or(forward_camera());
    const bool sized = scene.photo && scene.photo->size.width > 0;
    const ImageSize image = sized ? scene.photo->size : ImageSize{1242, 375};
    std::vector<KittiObject> labels;
    for (const LabeledObject& object : scene.objects) {
      labels.push_back(to_label(object, calibration, image, scene.calibration.has_value()));
    }
    const std::string part(KittiDataset::folder(split));
    const Folder base = root() / part;
    const auto file = [&](const char* folder, const char* ending) {
      make_folder(base / folder);
      return base / folder / (scene.name + ending);
    };
    write_point_cloud(file("velodyne", ".bin"), scene.cloud.view());
    write_file(file("calib", ".txt"), format_kitti_calibration(calibration));
    if (part == kTrainingFolder) {
      write_file(file("label_2", ".txt"), format_kitti_labels(labels, kKittiDecimals));
      if (!scene.labelled) note("scans without labels became scans with no objects");
    } else if (scene.labelled) {
      note("labelled scans of the split test lost their labels, which the layout has no place for");
    }
    copy_photo(scene, base / "image_2");
  }

  static void copy_photo(const LabeledScene& scene, const Folder& folder) {
    if (!scene.photo || scene.photo->path.extension() != ".png" || !scene.calibration) return;
    make_folder(folder);
    write_file(folder / (scene.name + ".png"), read_file(scene.photo->path));
  }

  void write_rest() override { write_lists(root() / "ImageSets", "", ".txt"); }
};

}  // namespace

bool fits_kitti(const Folder& root) {
  return fs::is_directory(root / "training" / "velodyne") ||
         fs::is_directory(root / "testing" / "velodyne") ||
         fs::is_directory(root / "training" / "label_2");
}

Reader open_kitti(const Folder& root, const DatasetOptions&) {
  return std::make_unique<KittiReader>(root);
}

Writer create_kitti(const NewDataset& dataset) {
  return std::make_unique<KittiWriter>(dataset.root);
}

}  // namespace arbox::io::internal
