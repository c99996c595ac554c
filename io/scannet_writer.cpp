#include <algorithm>
#include <atomic>

#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/scannet_instances.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/io/scannet.h"

// ScanNet's raw release behind DatasetWriter.

namespace arbox::io::internal {
namespace {

constexpr int kMostNyuId = 40;
// Hulls that differ less are the same boxes.
constexpr double kSameHull = 1e-3;
constexpr const char* kUnaligned = "axisAlignment = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";

std::vector<std::string> nyu40_names() {
  std::vector<std::string> names;
  for (int id = 1; id <= kMostNyuId; ++id) names.emplace_back(nyu40_name(id));
  return names;
}

std::string label_map() {
  std::string text = "id\traw_category\tcategory\tcount\tnyu40id\n";
  for (int id = 1; id <= kMostNyuId; ++id) {
    const std::string name(nyu40_name(id)), number = std::to_string(id);
    text += number + "\t" + name + "\t" + name + "\t1\t" + number + "\n";
  }
  return text;
}

/// Points with colours alone, as the release's meshes have them; grey where there are none.
geometry::PointCloud mesh_of(const geometry::PointCloud& cloud) {
  const auto view = cloud.view();
  geometry::PointCloud mesh{.channels = {"r", "g", "b"}, .values = {}};
  mesh.values.reserve(cloud.size() * mesh.columns());
  const geometry::Channel* colors[3] = {view.find("r"), view.find("g"), view.find("b")};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point = view.position(i);
    mesh.values.insert(mesh.values.end(), point.data(), point.data() + 3);
    for (const geometry::Channel* color : colors) {
      mesh.values.push_back(color == nullptr ? 0.5F : static_cast<float>(view.value(*color, i)));
    }
  }
  return mesh;
}

class ScanNetWriter : public AccountingWriter {
 public:
  explicit ScanNetWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kRoom,
                                  .boxes = BoxForm::kAxisAligned,
                                  .classes = nyu40_names()}) {
    make_folder(root() / "scans");
    write_file(root() / "scannetv2-labels.combined.tsv", label_map());
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    const Folder folder = root() / "scans" / scene.name;
    make_folder(folder);
    const auto file = [&](const char* ending) { return folder / (scene.name + ending); };
    write_point_cloud(file("_vh_clean_2.ply"), mesh_of(scene.cloud).view());
    write_file(file(".txt"), kUnaligned);
    if (!scene.labelled) return;
    const auto count = static_cast<std::int64_t>(scene.objects.size());
    std::vector<std::int64_t> segments;
    std::vector<std::int32_t> instances;
    // An object is one segment; what is no object is another one.
    for (const std::int32_t object : objects_of_points(scene)) {
      segments.push_back(object < 0 ? count : object);
      instances.push_back(object + 1);
    }
    std::vector<ScanNetGroup> groups;
    for (std::int64_t i = 0; i < count; ++i) groups.push_back({i, scene.objects[i].label, {i}});
    write_file(file(".aggregation.json"), format_scannet_aggregation(scene.name, groups));
    write_file(file("_vh_clean_2.0.010000.segs.json"),
               format_scannet_segments(scene.name, segments));
    tell_changes(scene, instances);
  }

  void tell_changes(const LabeledScene& scene, const std::vector<std::int32_t>& instances) {
    const auto hulls = instance_boxes(scene.cloud, instances, scene.objects.size());
    std::size_t lost = 0, changed = 0;
    for (std::size_t i = 0; i < hulls.size(); ++i) {
      const geometry::Box& box = scene.objects[i].box;
      const bool empty = hulls[i].size.isZero();
      lost += empty ? 1 : 0;
      changed += !empty && ((hulls[i].center - box.center).norm() > kSameHull ||
                            (hulls[i].size - box.size).norm() > kSameHull)
                     ? 1
                     : 0;
    }
    note("objects without points are lost: the layout has no boxes but the hulls of points", lost);
    note("boxes became the hulls of the points in them, as the layout has no others", changed);
  }

  void write_rest() override { write_lists(root(), "scannetv2_", ".txt"); }
};

}  // namespace

Writer create_scannet_raw(const NewDataset& dataset) {
  return std::make_unique<ScanNetWriter>(dataset.root);
}

}  // namespace arbox::io::internal
