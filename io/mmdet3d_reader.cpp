#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/colored_rows.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/scannet_instances.h"
#include "arbox/io/mmdet3d.h"
#include "arbox/io/scannet.h"
#include "arbox/io/sunrgbd.h"

// mmdetection3d's folders of ScanNet and SUN RGB-D behind DatasetReader.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

class Mmdet3dReader : public ListedDataset {
 public:
  Mmdet3dReader(const Folder& folder, const DatasetOptions& options, bool scannet)
      : ListedDataset(folder), scannet_(scannet) {
    const std::string prefix = scannet ? "scannet_infos_" : "sunrgbd_infos_";
    std::vector<std::string> all;
    std::vector<Mmdet3dInfo> infos;
    for (const std::string& file : names_in(folder, ".pkl")) {
      if (!file.starts_with(prefix)) continue;
      std::vector<std::string> names;
      for (Mmdet3dInfo& info : read_mmdet3d_infos(read_pickle(folder / (file + ".pkl")))) {
        names.push_back(info.name);
        infos.push_back(std::move(info));
      }
      all.insert(all.end(), names.begin(), names.end());
      add_split(file.substr(prefix.size()), std::move(names));
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    add_split(std::string(kAllScenes), std::move(all));
    if (!scannet) choose_sense(infos, options);
    for (Mmdet3dInfo& info : infos) infos_.emplace(info.name, std::move(info));
  }

  std::string_view layout() const override {
    return scannet_ ? "scannet-mmdet3d" : "sunrgbd-mmdet3d";
  }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override {
    return scannet_ ? scannet_class_names() : sunrgbd_class_names();
  }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    require_scene(split, name);
    const Mmdet3dInfo& info = infos_.at(std::string(name));
    LabeledScene scene{.name = info.name, .frame = SceneFrame::kRoom};
    scene.labelled = info.labelled;
    read_points(scene, info);
    align(scene.cloud, info.alignment);
    for (std::size_t i = 0; i < info.boxes.size(); ++i) add_object(scene, info, i);
    if (scannet_ && scene.labelled) read_point_labels(scene);
    const fs::path image = find_image(info);
    if (info.projection && !image.empty()) {
      scene.photo = {.path = image, .projection = *info.projection};
    }
    return scene;
  }

 private:
  void choose_sense(const std::vector<Mmdet3dInfo>& infos, const DatasetOptions& options) {
    if (!options.yaw.empty()) {
      sense_ = options.yaw == "clockwise" ? YawSense::kClockwise : YawSense::kCounterClockwise;
      return;
    }
    const auto found = find_yaw_sense(infos);
    const bool turned = std::any_of(infos.begin(), infos.end(), [](const Mmdet3dInfo& info) {
      return std::any_of(info.boxes.begin(), info.boxes.end(),
                         [](const auto& box) { return box[6] != 0.0; });
    });
    if (!found && turned) {
      throw FormatError(root().string() +
                        ": nothing in the infos tells which way yaw runs; say it with the option "
                        "yaw: clockwise for files made before mmdetection3d 1.0, "
                        "counter-clockwise for later ones");
    }
    sense_ = found.value_or(YawSense::kCounterClockwise);
  }

  void read_points(LabeledScene& scene, const Mmdet3dInfo& info) const {
    const fs::path written = root() / info.points;
    scene.source =
        fs::exists(written) ? written : root() / "points" / fs::path(info.points).filename();
    const std::string bytes = read_file(scene.source);
    if (info.columns < 3 || info.columns > 64 || bytes.size() % (4 * info.columns) != 0) {
      throw FormatError(scene.source.string() + ": expected rows of " +
                        std::to_string(info.columns) + " float32 numbers, got " +
                        std::to_string(bytes.size()) + " bytes");
    }
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    const std::size_t kept = info.columns >= 6 ? 6 : 3;
    if (kept != info.columns) {
      std::size_t to = 0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % info.columns < kept) values[to++] = values[i];
      }
      values.resize(to);
    }
    scene.cloud = colored_cloud(std::move(values), kept);
  }

  /// The masks beside the points, where both are there with a number a point.
  void read_point_labels(LabeledScene& scene) const {
    const auto read = [&](const char* folder) {
      const fs::path path = root() / folder / (scene.name + ".bin");
      std::vector<std::int32_t> numbers;
      if (!fs::exists(path)) return numbers;
      const std::string bytes = read_file(path);
      if (bytes.size() != scene.cloud.size() * sizeof(std::int64_t)) {
        throw FormatError(path.string() + ": expected an int64 number a point (" +
                          std::to_string(scene.cloud.size()) + "), got " +
                          std::to_string(bytes.size()) + " bytes");
      }
      for (std::size_t i = 0; i < bytes.size(); i += sizeof(std::int64_t)) {
        std::int64_t number = 0;
        std::memcpy(&number, bytes.data() + i, sizeof(number));
        numbers.push_back(static_cast<std::int32_t>(
            std::clamp<std::int64_t>(number, -1, std::numeric_limits<std::int32_t>::max())));
      }
      return numbers;
    };
    const auto instances = read("instance_mask"), nyu40 = read("semantic_mask");
    if (instances.empty() || nyu40.empty()) return;
    scene.point_objects = objects_of_instances(scene, instances, nyu40);
  }

  void add_object(LabeledScene& scene, const Mmdet3dInfo& info, std::size_t i) const {
    const auto& b = info.boxes[i];
    const double yaw = sense_ == YawSense::kClockwise ? -b[6] : b[6];
    LabeledObject object{.label = info.labels[i],
                         .box = geometry::make_yaw_box({b[0], b[1], b[2]}, {b[3], b[4], b[5]}, yaw),
                         .heading = scannet_ ? Heading::kUnknown : Heading::kKnown};
    if (!info.image_boxes.empty()) {
      const auto& seen = info.image_boxes[i];
      object.attributes = {
          {"left", seen[0]}, {"top", seen[1]}, {"right", seen[2]}, {"bottom", seen[3]}};
    }
    const std::string place =
        root().string() + ": infos of " + info.name + ", box " + std::to_string(i);
    try {
      geometry::require_valid(object.box, place);
    } catch (const InvalidArgument& error) {
      throw FormatError(error.what());
    }
    scene.objects.push_back(std::move(object));
  }

  fs::path find_image(const Mmdet3dInfo& info) const {
    const fs::path file = fs::path(info.image).filename();
    for (const char* folder : {"sunrgbd_trainval/image", "image"}) {
      if (!file.empty() && fs::exists(root() / folder / file)) return root() / folder / file;
    }
    return {};
  }

  bool scannet_;
  YawSense sense_ = YawSense::kCounterClockwise;
  std::map<std::string, Mmdet3dInfo> infos_;
};

bool has_infos(const Folder& root, std::string_view prefix) {
  const auto files = names_in(root, ".pkl");
  return std::any_of(files.begin(), files.end(),
                     [&](const std::string& file) { return file.starts_with(prefix); });
}

}  // namespace

bool fits_mmdet3d_scannet(const Folder& root) { return has_infos(root, "scannet_infos_"); }
bool fits_mmdet3d_sunrgbd(const Folder& root) { return has_infos(root, "sunrgbd_infos_"); }

Reader open_mmdet3d_scannet(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<Mmdet3dReader>(root, options, true);
}

Reader open_mmdet3d_sunrgbd(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<Mmdet3dReader>(root, options, false);
}

}  // namespace arbox::io::internal
