#include <algorithm>
#include <array>
#include <unordered_map>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/io/scannet.h"

// ScanNet's raw release behind DatasetReader.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMesh = "_vh_clean_2.ply";
constexpr const char* kSegments = "_vh_clean_2.0.010000.segs.json";
constexpr std::array<std::string_view, 2> kAggregations = {".aggregation.json",
                                                           "_vh_clean.aggregation.json"};
constexpr const char* kLabelMap = "scannetv2-labels.combined.tsv";

/// Where scenes lie: ROOT/scans and ROOT/scans_test, or ROOT itself.
std::vector<Folder> scan_folders(const Folder& root) {
  std::vector<Folder> folders;
  for (const char* name : {"scans", "scans_test"}) {
    if (fs::is_directory(root / name)) folders.push_back(root / name);
  }
  if (folders.empty()) folders.push_back(root);
  return folders;
}

bool is_scene(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / (folder.filename().string() + kMesh), ignored);
}

/// The first of several places that has a file.
fs::path find_beside(const Folder& root, const std::string& name) {
  for (const fs::path& folder :
       {root, root / "meta_data", root.parent_path(), root.parent_path() / "meta_data"}) {
    if (fs::exists(folder / name)) return folder / name;
  }
  return {};
}

/// Segments to vertices that stand for themselves: the object of each vertex, from 1, 0 for none.
class Instances {
 public:
  Instances(const std::vector<std::int64_t>& segments, const std::vector<ScanNetGroup>& groups) {
    std::unordered_map<std::int64_t, std::int32_t> group_of_segment;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      for (const std::int64_t segment : groups[i].segments) {
        // As in the reference tools, later groups win.
        group_of_segment[segment] = static_cast<std::int32_t>(i) + 1;
      }
    }
    of_vertex_.reserve(segments.size());
    for (const std::int64_t segment : segments) {
      const auto found = group_of_segment.find(segment);
      of_vertex_.push_back(found == group_of_segment.end() ? 0 : found->second);
    }
  }

  const std::vector<std::int32_t>& of_vertex() const { return of_vertex_; }

 private:
  std::vector<std::int32_t> of_vertex_;
};

class ScanNetReader : public ListedDataset {
 public:
  ScanNetReader(const Folder& root, const DatasetOptions& options)
      : ListedDataset(root), all_classes_(options.classes == "all") {
    const fs::path map = find_beside(root, kLabelMap);
    if (map.empty()) {
      throw IoError(root.string() + ": expected ScanNet's label map " + kLabelMap +
                    " in the folder or beside it");
    }
    label_map_ = parse_scannet_label_map(read_file(map), map.string());
    std::vector<std::string> all;
    for (const Folder& folder : scan_folders(root)) {
      for (const auto& entry : fs::directory_iterator(folder)) {
        if (!is_scene(entry.path())) continue;
        all.push_back(entry.path().filename().string());
        folders_[all.back()] = entry.path();
      }
    }
    std::sort(all.begin(), all.end());
    for (const char* split : {"train", "val", "test"}) {
      const fs::path list = find_beside(root, std::string("scannetv2_") + split + ".txt");
      if (!list.empty()) add_split(split, read_kitti_split(list));
    }
    add_split(std::string(kAllScenes), std::move(all));
  }

  std::string_view layout() const override { return "scannet"; }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override {
    return all_classes_ ? std::vector<std::string>{} : scannet_class_names();
  }

  LabeledScene load(std::string_view, std::string_view name) const override {
    const auto found = folders_.find(std::string(name));
    if (found == folders_.end()) {
      throw IoError(root().string() + ": no folder scans/" + std::string(name) + " with a mesh " +
                    std::string(name) + kMesh);
    }
    LabeledScene scene{.name = std::string(name), .frame = SceneFrame::kRoom};
    const fs::path base = found->second / scene.name;
    const auto file = [&](std::string_view ending) {
      return fs::path(base.string() + std::string(ending));
    };
    scene.source = file(kMesh);
    scene.cloud = read_point_cloud(scene.source, {.keep_non_finite = true}).points;
    if (fs::exists(file(".txt"))) {
      align(scene.cloud, parse_scannet_alignment(read_file(file(".txt")), file(".txt").string()));
    }
    const fs::path groups = first_file(found->second, scene.name, kAggregations);
    scene.labelled = !groups.empty();
    if (scene.labelled) label(scene, groups, file(kSegments));
    return scene;
  }

 private:
  void label(LabeledScene& scene, const fs::path& groups_file,
             const fs::path& segments_file) const {
    const auto groups = parse_scannet_aggregation(read_file(groups_file), groups_file.string());
    const auto segments = parse_scannet_segments(read_file(segments_file), segments_file.string());
    if (segments.size() != scene.cloud.size()) {
      throw FormatError(segments_file.string() + ": expected one segment a vertex (" +
                        std::to_string(scene.cloud.size()) + "), got " +
                        std::to_string(segments.size()));
    }
    const Instances instances(segments, groups);
    const auto boxes = instance_boxes(scene.cloud, instances.of_vertex(), groups.size());
    std::vector<std::int32_t> object_of_group(groups.size(), -1);
    std::vector<std::size_t> order(groups.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return groups[a].object_id < groups[b].object_id;
    });
    for (const std::size_t i : order) {
      const int id = nyu40_id(groups[i].label);
      if (!is_wanted(id) || !(boxes[i].size.array() > 0.0).all()) continue;
      object_of_group[i] = static_cast<std::int32_t>(scene.objects.size());
      scene.objects.push_back(
          {.label = std::string(nyu40_name(id)),
           .box = boxes[i],
           .heading = Heading::kUnknown,
           .attributes = {{"instance", static_cast<double>(groups[i].object_id + 1)},
                          {"nyu40", static_cast<double>(id)}}});
    }
    scene.point_objects.reserve(scene.cloud.size());
    for (const std::int32_t instance : instances.of_vertex()) {
      scene.point_objects.push_back(instance == 0 ? -1 : object_of_group[instance - 1]);
    }
  }

  int nyu40_id(const std::string& label) const {
    const auto found = label_map_.find(label);
    return found == label_map_.end() ? 0 : found->second;
  }

  bool is_wanted(int id) const {
    if (all_classes_) return id > 0;
    const auto classes = scannet_classes();
    return std::any_of(classes.begin(), classes.end(),
                       [&](const ScanNetClass& one) { return one.nyu40_id == id; });
  }

  bool all_classes_;
  std::map<std::string, int> label_map_;
  std::map<std::string, fs::path> folders_;
};

}  // namespace

bool fits_scannet_raw(const Folder& root) {
  for (const Folder& folder : scan_folders(root)) {
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
      if (entry->is_directory(error) && is_scene(entry->path())) return true;
    }
  }
  return false;
}

Reader open_scannet_raw(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<ScanNetReader>(root, options);
}

}  // namespace arbox::io::internal
