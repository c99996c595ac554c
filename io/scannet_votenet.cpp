#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/colored_rows.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/scannet_instances.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/npy.h"
#include "arbox/io/scannet.h"

// ScanNet as VoteNet's and mmdetection3d's scripts prepare it, one .npy a kind of data.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrepared = "scannet_train_detection_data";
constexpr std::size_t kScanNetBoxColumns = 7;

Folder data_folder(const Folder& root) {
  for (const char* name : {kPrepared, "scannet_instance_data"}) {
    if (fs::is_directory(root / name)) return root / name;
  }
  return root;
}

std::vector<std::int32_t> read_labels(const fs::path& path, std::size_t points) {
  const NpyArray array = read_npy(path);
  if (array.shape().size() != 1 || array.size() != points) {
    throw FormatError(path.string() + ": expected one label a point (" + std::to_string(points) +
                      "), got " + std::to_string(array.size()) + " numbers");
  }
  return array.values<std::int32_t>();
}

std::vector<LabeledObject> read_boxes(const fs::path& path) {
  const NpyArray array = read_npy(path);
  if (array.shape().size() != 2 || (array.shape()[1] != kScanNetBoxColumns && array.size() > 0)) {
    throw FormatError(path.string() + ": expected rows of 7 numbers (centre, sizes, NYU40 id)");
  }
  const std::vector<double> rows = array.values<double>();
  std::vector<LabeledObject> objects;
  for (std::size_t i = 0; i < rows.size(); i += kScanNetBoxColumns) {
    const double* row = rows.data() + i;
    LabeledObject& object = objects.emplace_back();
    object.label = nyu40_name(row[6] >= 1 && row[6] <= 40 ? static_cast<int>(row[6]) : 0);
    object.box.center = Eigen::Vector3d(row[0], row[1], row[2]);
    object.box.size = Eigen::Vector3d(row[3], row[4], row[5]);
    object.heading = Heading::kUnknown;
    object.attributes["nyu40"] = row[6];
    const std::string place = path.string() + ": row " + std::to_string(i / kScanNetBoxColumns);
    if (object.label.empty())
      throw FormatError(place + ": expected an NYU40 id of 1..40 at its end");
    try {
      geometry::require_valid(object.box, place);
    } catch (const InvalidArgument& error) {
      throw FormatError(error.what());
    }
  }
  return objects;
}

class VotenetReader : public ListedDataset {
 public:
  explicit VotenetReader(const Folder& root) : ListedDataset(root), data_(data_folder(root)) {
    for (const char* split : {"train", "val", "test"}) {
      const std::string list = std::string("scannetv2_") + split + ".txt";
      for (const Folder& folder :
           {root / "meta_data", root, data_.parent_path() / "meta_data", data_.parent_path()}) {
        if (!fs::exists(folder / list)) continue;
        add_split(split, read_kitti_split(folder / list));
        break;
      }
    }
    add_split(std::string(kAllScenes), names_in(data_, "_vert.npy"));
  }

  std::string_view layout() const override { return "scannet-votenet"; }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override { return scannet_class_names(); }

  LabeledScene load(std::string_view, std::string_view name) const override {
    LabeledScene scene{.name = std::string(name), .frame = SceneFrame::kRoom};
    scene.source = file(name, "_vert.npy");
    std::vector<std::int32_t> kept;
    const NpyArray rows = read_npy(scene.source);
    scene.cloud = colored_cloud(rows, scene.source.string(), &kept);
    if (fs::exists(file(name, "_axis_align_matrix.npy"))) align_cloud(scene);
    const bool aligned = fs::exists(file(name, "_aligned_bbox.npy"));
    const fs::path boxes = file(name, aligned ? "_aligned_bbox.npy" : "_bbox.npy");
    scene.labelled = fs::exists(boxes);
    if (!scene.labelled) return scene;
    scene.objects = read_boxes(boxes);
    if (fs::exists(file(name, "_ins_label.npy")) && fs::exists(file(name, "_sem_label.npy"))) {
      read_instances(scene, kept, rows.shape()[0]);
    }
    return scene;
  }

 private:
  fs::path file(std::string_view name, std::string_view ending) const {
    return data_ / (std::string(name) + std::string(ending));
  }

  void align_cloud(LabeledScene& scene) const {
    const fs::path path = file(scene.name, "_axis_align_matrix.npy");
    const NpyArray array = read_npy(path);
    if (array.shape() != std::vector<std::size_t>{4, 4}) {
      throw FormatError(path.string() + ": expected a 4 x 4 matrix");
    }
    const std::vector<double> numbers = array.values<double>();
    align(scene.cloud,
          Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data()));
  }

  void read_instances(LabeledScene& scene, const std::vector<std::int32_t>& kept,
                      std::size_t rows) const {
    const auto instances = read_labels(file(scene.name, "_ins_label.npy"), rows);
    const auto nyu40 = read_labels(file(scene.name, "_sem_label.npy"), rows);
    std::vector<std::int32_t> kept_instances, kept_nyu40;
    for (const std::int32_t row : kept) {
      kept_instances.push_back(instances[row]);
      kept_nyu40.push_back(nyu40[row]);
    }
    scene.point_objects = objects_of_instances(scene, kept_instances, kept_nyu40);
  }

  Folder data_;
};

class VotenetWriter : public AccountingWriter {
 public:
  explicit VotenetWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kRoom,
                                  .boxes = BoxForm::kAxisAligned,
                                  .classes = scannet_class_names()}) {
    make_folder(root() / kPrepared);
    make_folder(root() / "meta_data");
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    const auto file = [&](const char* ending) {
      return root() / kPrepared / (scene.name + ending);
    };
    write_npy<float>(file("_vert.npy"), colored_rows(scene.cloud, 255.0F), {scene.cloud.size(), 6});
    if (!scene.labelled) return;
    std::vector<double> boxes;
    for (const LabeledObject& object : scene.objects) {
      for (int i = 0; i < 3; ++i) boxes.push_back(object.box.center[i]);
      for (int i = 0; i < 3; ++i) boxes.push_back(object.box.size[i]);
      boxes.push_back(nyu40_id(object.label));
    }
    write_npy<double>(file("_bbox.npy"), boxes, {scene.objects.size(), kScanNetBoxColumns});
    const ScanNetPointLabels labels = scannet_point_labels(scene);
    const auto write_labels = [&](const char* ending, const std::vector<std::int64_t>& numbers) {
      const std::vector<std::uint32_t> narrow(numbers.begin(), numbers.end());
      write_npy<std::uint32_t>(file(ending), narrow, {narrow.size()});
    };
    write_labels("_ins_label.npy", labels.instances);
    write_labels("_sem_label.npy", labels.nyu40);
  }

  void write_rest() override { write_lists(root() / "meta_data", "scannetv2_", ".txt"); }
};

}  // namespace

bool fits_scannet_votenet(const Folder& root) {
  return !names_in(data_folder(root), "_vert.npy").empty();
}

Reader open_scannet_votenet(const Folder& root, const DatasetOptions&) {
  return std::make_unique<VotenetReader>(root);
}

Writer create_scannet_votenet(const NewDataset& dataset) {
  return std::make_unique<VotenetWriter>(dataset.root);
}

}  // namespace arbox::io::internal
