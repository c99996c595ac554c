#include <algorithm>
#include <map>
#include <mutex>
#include <set>

#include "arbox/io/annotation_tools.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/point_cloud_file.h"

// Folders of labelCloud and CVAT behind DatasetWriter.

namespace arbox::io::internal {
namespace {

class LabelCloudWriter : public AccountingWriter {
 public:
  explicit LabelCloudWriter(const Folder& folder) : AccountingWriter(folder, {}) {
    make_folder(root() / "pointclouds");
    make_folder(root() / "labels");
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    const std::string cloud = scene.name + ".pcd";
    write_point_cloud(root() / "pointclouds" / cloud, scene.cloud.view());
    if (!scene.labelled) return;
    write_file(root() / "labels" / (scene.name + ".json"),
               format_labelcloud_vertices(scene.objects, cloud));
    const std::scoped_lock lock(mutex_);
    for (const LabeledObject& object : scene.objects) classes_.insert(object.label);
  }

  void write_rest() override {
    write_file(
        root() / "labels" / "_classes.json",
        format_labelcloud_classes(std::vector<std::string>(classes_.begin(), classes_.end())));
  }

  std::mutex mutex_;
  std::set<std::string> classes_;
};

class CvatWriter : public AccountingWriter {
 public:
  explicit CvatWriter(const Folder& folder)
      : AccountingWriter(folder, {}), clouds_(folder / "velodyne_points" / "data") {
    make_folder(clouds_);
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    if (!scene.labelled) note("scans without labels became scans with no objects");
    write_point_cloud(clouds_ / (scene.name + ".pcd"), scene.cloud.view());
    const std::scoped_lock lock(mutex_);
    objects_.emplace(scene.name, scene.objects);
  }

  void write_rest() override {
    Tracklets tracklets;
    std::string frames;
    std::int64_t frame = 0;
    for (auto& [name, objects] : objects_) {
      frames += std::to_string(frame) + " " + name + "\n";
      tracklets[frame++] = std::move(objects);
    }
    write_file(root() / "frame_list.txt", frames);
    write_file(root() / "tracklet_labels.xml", format_cvat_tracklets(tracklets));
  }

  Folder clouds_;
  std::mutex mutex_;
  std::map<std::string, std::vector<LabeledObject>> objects_;
};

}  // namespace

Writer create_labelcloud(const NewDataset& dataset) {
  return std::make_unique<LabelCloudWriter>(dataset.root);
}

Writer create_cvat(const NewDataset& dataset) { return std::make_unique<CvatWriter>(dataset.root); }

}  // namespace arbox::io::internal
