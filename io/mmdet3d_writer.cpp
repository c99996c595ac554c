#include <map>
#include <mutex>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/colored_rows.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/scannet_instances.h"
#include "arbox/io/mmdet3d.h"
#include "arbox/io/pickle_writer.h"
#include "arbox/io/scannet.h"
#include "arbox/io/sunrgbd.h"

// mmdetection3d's folders of ScanNet and SUN RGB-D behind DatasetWriter.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImageFolder = "sunrgbd_trainval/image";
constexpr std::size_t kCloudColumns = 6;

template <class T>
std::string_view raw_bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// What an infos file says of one scan.
struct InfoRecord {
  bool labelled = false, point_labels = false;
  std::vector<std::int64_t> classes;
  std::vector<std::string> names;
  /// Centres, sizes, yaws in the file's sense; 3, 3 and 1 numbers a box.
  std::vector<double> centers, sizes, yaws;
  /// 4 numbers a box, or none.
  std::vector<double> image_boxes;
  /// The image's file and camera; the file is empty if there is none.
  std::string image;
  ImageSize image_size;
  SunRgbdCalibration calibration;
};

class InfosWriter : public AccountingWriter {
 public:
  InfosWriter(const NewDataset& dataset, bool scannet)
      : AccountingWriter(dataset.root,
                         {.frame = SceneFrame::kRoom,
                          .boxes = scannet ? BoxForm::kAxisAligned : BoxForm::kUpright,
                          .classes = scannet ? scannet_class_names() : sunrgbd_class_names()}),
        scannet_(scannet),
        infos_(dataset.options.infos) {
    make_folder(root() / "points");
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    InfoRecord record = record_of(scene);
    write_file(root() / "points" / (scene.name + ".bin"),
               raw_bytes(colored_rows(scene.cloud, scannet_ ? 255.0F : 1.0F)));
    if (scannet_ && scene.labelled) {
      const ScanNetPointLabels labels = scannet_point_labels(scene);
      for (const auto& [folder, numbers] : {std::pair{"instance_mask", &labels.instances},
                                            std::pair{"semantic_mask", &labels.nyu40}}) {
        make_folder(root() / folder);
        write_file(root() / folder / (scene.name + ".bin"), raw_bytes(*numbers));
      }
      record.point_labels = true;
    }
    if (!record.image.empty()) {
      make_folder(root() / kImageFolder);
      write_file(root() / kImageFolder / record.image, read_file(scene.photo->path));
    }
    const std::scoped_lock lock(mutex_);
    records_.emplace(scene.name, std::move(record));
  }

  InfoRecord record_of(const LabeledScene& scene) const {
    InfoRecord record;
    record.labelled = scene.labelled;
    for (const LabeledObject& object : scene.objects) {
      const geometry::Box& box = object.box;
      record.classes.push_back(static_cast<std::int64_t>(class_number(object)));
      record.names.push_back(object.label);
      record.centers.insert(record.centers.end(), box.center.data(), box.center.data() + 3);
      record.sizes.insert(record.sizes.end(), box.size.data(), box.size.data() + 3);
      const double yaw = scannet_ ? 0.0 : geometry::yaw(box);
      record.yaws.push_back(infos_ == "0.x" ? -yaw : yaw);
      for (const char* edge : {"left", "top", "right", "bottom"}) {
        const auto found = object.attributes.find(edge);
        if (found != object.attributes.end()) record.image_boxes.push_back(found->second);
      }
    }
    if (record.image_boxes.size() != 4 * scene.objects.size()) record.image_boxes.clear();
    const auto camera = scene.photo ? calibration_of(scene.photo->projection) : std::nullopt;
    if (camera && !scannet_) {
      record.image = scene.name + scene.photo->path.extension().string();
      record.image_size = scene.photo->size;
      record.calibration = *camera;
    }
    return record;
  }

  void write_rest() override {
    const std::string prefix = scannet_ ? "scannet_infos_" : "sunrgbd_infos_";
    for (const auto& [split, names] : lists()) {
      PickleWriter pickle;
      infos_ == "1.1" ? put_newer(pickle, names) : put_older(pickle, names);
      write_file(root() / (prefix + split + ".pkl"), std::move(pickle).finish());
    }
  }

  static void put_identity(PickleWriter& pickle) {
    pickle.text("axis_align_matrix");
    const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
    pickle.rows({identity.data(), 16}, 4);
  }

  void put_newer(PickleWriter& pickle, const std::vector<std::string>& names) const {
    pickle.begin_dict();
    pickle.text("metainfo"), pickle.begin_dict();
    pickle.text("categories"), pickle.begin_dict();
    for (std::size_t i = 0; i < classes().size(); ++i) {
      pickle.text(classes()[i]), pickle.integer(static_cast<std::int64_t>(i));
    }
    pickle.end();
    pickle.text("dataset"), pickle.text(scannet_ ? "scannet" : "sunrgbd");
    pickle.text("info_version"), pickle.text("1.1");
    if (!scannet_) pickle.text("yaw"), pickle.text("counter-clockwise");
    pickle.end();
    pickle.text("data_list"), pickle.begin_list();
    for (const std::string& name : names) put_newer(pickle, name, records_.at(name));
    pickle.end();
    pickle.end();
  }

  void put_newer(PickleWriter& pickle, const std::string& name, const InfoRecord& record) const {
    pickle.begin_dict();
    pickle.text("sample_idx"), pickle.text(name);
    pickle.text("lidar_points"), pickle.begin_dict();
    pickle.text("num_pts_feats"), pickle.integer(kCloudColumns);
    pickle.text("lidar_path"), pickle.text(name + ".bin");
    pickle.end();
    if (scannet_) put_identity(pickle);
    if (record.point_labels) {
      pickle.text("pts_instance_mask_path"), pickle.text(name + ".bin");
      pickle.text("pts_semantic_mask_path"), pickle.text(name + ".bin");
    }
    if (!record.image.empty()) put_camera(pickle, record);
    if (record.labelled) {
      pickle.text("instances"), pickle.begin_list();
      for (std::size_t i = 0; i < record.classes.size(); ++i) put_instance(pickle, record, i);
      pickle.end();
    }
    pickle.end();
  }

  /// Centre, sizes and, where boxes turn, yaw.
  std::vector<double> row_of(const InfoRecord& record, std::size_t i) const {
    std::vector<double> row(scannet_ ? 6 : 7, record.yaws[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      row[k] = record.centers[3 * i + k];
      row[3 + k] = record.sizes[3 * i + k];
    }
    return row;
  }

  void put_instance(PickleWriter& pickle, const InfoRecord& record, std::size_t i) const {
    pickle.begin_dict();
    pickle.text("bbox_3d"), pickle.numbers(row_of(record, i));
    pickle.text("bbox_label_3d"), pickle.integer(record.classes[i]);
    if (!record.image_boxes.empty()) {
      pickle.text("bbox"), pickle.numbers(std::span(record.image_boxes).subspan(4 * i, 4));
      pickle.text("bbox_label"), pickle.integer(record.classes[i]);
    }
    pickle.end();
  }

  static void put_camera(PickleWriter& pickle, const InfoRecord& record) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> matrix =
        io::projection_of(record.calibration).leftCols<3>();
    pickle.text("images"), pickle.begin_dict();
    pickle.text("CAM0"), pickle.begin_dict();
    pickle.text("img_path"), pickle.text(record.image);
    pickle.text("depth2img"), pickle.rows({matrix.data(), 9}, 3);
    if (record.image_size.width > 0) {
      pickle.text("height"), pickle.integer(record.image_size.height);
      pickle.text("width"), pickle.integer(record.image_size.width);
    }
    pickle.end();
    pickle.end();
  }

  void put_older(PickleWriter& pickle, const std::vector<std::string>& names) const {
    pickle.begin_list();
    for (const std::string& name : names) {
      const InfoRecord& record = records_.at(name);
      pickle.begin_dict();
      pickle.text("point_cloud"), pickle.begin_dict();
      pickle.text("num_features"), pickle.integer(kCloudColumns);
      pickle.text("lidar_idx"), pickle.text(name);
      pickle.end();
      pickle.text("pts_path"), pickle.text("points/" + name + ".bin");
      if (record.point_labels) {
        pickle.text("pts_instance_mask_path"), pickle.text("instance_mask/" + name + ".bin");
        pickle.text("pts_semantic_mask_path"), pickle.text("semantic_mask/" + name + ".bin");
      }
      if (!record.image.empty()) put_older_camera(pickle, name, record);
      if (record.labelled) put_annotations(pickle, record);
      pickle.end();
    }
    pickle.end();
  }

  static void put_older_camera(PickleWriter& pickle, const std::string& name,
                               const InfoRecord& record) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> intrinsic = record.calibration.intrinsic;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> tilt = record.calibration.tilt;
    pickle.text("image"), pickle.begin_dict();
    pickle.text("image_idx"), pickle.text(name);
    pickle.text("image_path"), pickle.text("image/" + record.image);
    if (record.image_size.width > 0) {
      const std::int32_t shape[] = {record.image_size.height, record.image_size.width};
      pickle.text("image_shape"), pickle.array<std::int32_t>(shape, {2});
    }
    pickle.end();
    pickle.text("calib"), pickle.begin_dict();
    pickle.text("K"), pickle.array<double>({intrinsic.data(), 9}, {3, 3});
    pickle.text("Rt"), pickle.array<double>({tilt.data(), 9}, {3, 3});
    pickle.end();
  }

  void put_annotations(PickleWriter& pickle, const InfoRecord& record) const {
    const std::size_t count = record.classes.size();
    pickle.text("annos"), pickle.begin_dict();
    pickle.text("gt_num"), pickle.integer(static_cast<std::int64_t>(count));
    if (scannet_) {
      const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
      pickle.text("axis_align_matrix"), pickle.array<double>({identity.data(), 16}, {4, 4});
    }
    if (count > 0) {
      std::vector<double> dimensions = record.sizes, rows;
      std::vector<std::int32_t> index;
      for (std::size_t i = 0; i < count; ++i) {
        // Before 1.0 SUN RGB-D's were length, height, width.
        if (!scannet_ && infos_ == "0.x") std::swap(dimensions[3 * i + 1], dimensions[3 * i + 2]);
        const std::vector<double> row = row_of(record, i);
        rows.insert(rows.end(), row.begin(), row.end());
        index.push_back(static_cast<std::int32_t>(i));
      }
      pickle.text("name"), pickle.texts(record.names);
      pickle.text("location"), pickle.array<double>(record.centers, {count, 3});
      pickle.text("dimensions"), pickle.array<double>(dimensions, {count, 3});
      pickle.text("gt_boxes_upright_depth");
      pickle.array<double>(rows, {count, rows.size() / count});
      pickle.text("class"), pickle.array<std::int64_t>(record.classes, {count});
      pickle.text("index"), pickle.array<std::int32_t>(index, {count});
      if (!scannet_) pickle.text("rotation_y"), pickle.array<double>(record.yaws, {count});
      if (!record.image_boxes.empty()) {
        pickle.text("bbox"), pickle.array<double>(record.image_boxes, {count, 4});
      }
    }
    pickle.end();
  }

  bool scannet_;
  std::string infos_;
  std::mutex mutex_;
  std::map<std::string, InfoRecord> records_;
};

}  // namespace

Writer create_mmdet3d_scannet(const NewDataset& dataset) {
  return std::make_unique<InfosWriter>(dataset, true);
}

Writer create_mmdet3d_sunrgbd(const NewDataset& dataset) {
  return std::make_unique<InfosWriter>(dataset, false);
}

}  // namespace arbox::io::internal
