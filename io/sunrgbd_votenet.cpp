#include <algorithm>
#include <array>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/colored_rows.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/npy.h"
#include "arbox/io/npz.h"
#include "arbox/io/sunrgbd.h"

// SUN RGB-D as VoteNet's script prepares it: one folder a split with NAME_pc.npz, NAME_bbox.npy and
// NAME_votes.npz.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrefix = "sunrgbd_pc_bbox_votes_";
constexpr const char* kCloud = "_pc.npz";
constexpr std::size_t kSunRgbdBoxColumns = 8;
constexpr std::size_t kVoteColumns = 10;

struct SplitFolder {
  std::string split;
  Folder folder;
};

/// Folders sunrgbd_pc_bbox_votes_..._SPLIT of the root, or the root itself.
std::vector<SplitFolder> split_folders(const Folder& root) {
  std::vector<SplitFolder> result;
  std::error_code error;
  for (fs::directory_iterator entry(root, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(kPrefix) || !entry->is_directory(error)) continue;
    result.push_back({name.substr(name.rfind('_') + 1), entry->path()});
  }
  std::sort(result.begin(), result.end(),
            [](const auto& a, const auto& b) { return a.split < b.split; });
  if (result.empty() && !names_in(root, kCloud).empty()) {
    result.push_back({std::string(kAllScenes), root});
  }
  return result;
}

LabeledObject read_box(const double* row, const std::string& place) {
  const std::vector<std::string> classes = sunrgbd_class_names();
  const double number = row[7];
  if (!(number >= 0) || number >= static_cast<double>(classes.size()) ||
      number != std::floor(number)) {
    throw FormatError(place + ": expected a class of 0..9 at its end");
  }
  LabeledObject object{.label = classes[static_cast<std::size_t>(number)]};
  // The file's sizes are halves and its heading runs clockwise.
  const Eigen::Vector3d size = 2.0 * Eigen::Vector3d(row[3], row[4], row[5]);
  object.box = geometry::make_yaw_box({row[0], row[1], row[2]}, size, -row[6]);
  try {
    geometry::require_valid(object.box, place);
  } catch (const InvalidArgument& error) {
    throw FormatError(error.what());
  }
  return object;
}

class SunVotenetReader : public ListedDataset {
 public:
  explicit SunVotenetReader(const Folder& folder)
      : ListedDataset(folder), folders_(split_folders(folder)) {
    std::vector<std::string> all;
    for (const SplitFolder& one : folders_) {
      std::vector<std::string> names = names_in(one.folder, kCloud);
      all.insert(all.end(), names.begin(), names.end());
      if (one.split != kAllScenes) add_split(one.split, std::move(names));
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    add_split(std::string(kAllScenes), std::move(all));
  }

  std::string_view layout() const override { return "sunrgbd-votenet"; }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override { return sunrgbd_class_names(); }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    LabeledScene scene{.name = std::string(name), .frame = SceneFrame::kRoom};
    const Folder folder = folder_of(split, scene.name);
    scene.source = folder / (scene.name + kCloud);
    const NpzFile archive = open_npz(scene.source);
    scene.cloud = colored_cloud(archive.read("pc"), scene.source.string());
    const fs::path boxes = folder / (scene.name + "_bbox.npy");
    scene.labelled = fs::exists(boxes);
    if (scene.labelled) read_boxes(scene, boxes);
    return scene;
  }

 private:
  Folder folder_of(std::string_view split, const std::string& name) const {
    for (const SplitFolder& one : folders_) {
      if (split != one.split && split != kAllScenes) continue;
      if (fs::exists(one.folder / (name + kCloud))) return one.folder;
    }
    throw IoError(root().string() + ": no cloud " + name + kCloud + " in split " +
                  std::string(split));
  }

  static void read_boxes(LabeledScene& scene, const fs::path& path) {
    const NpyArray array = read_npy(path);
    if (array.size() > 0 && (array.shape().size() != 2 || array.shape()[1] != kSunRgbdBoxColumns)) {
      throw FormatError(path.string() +
                        ": expected rows of 8 numbers (centre, half sizes, heading, class)");
    }
    const std::vector<double> rows = array.values<double>();
    for (std::size_t i = 0; i < rows.size(); i += kSunRgbdBoxColumns) {
      scene.objects.push_back(read_box(
          rows.data() + i, path.string() + ": row " + std::to_string(i / kSunRgbdBoxColumns)));
    }
  }

  std::vector<SplitFolder> folders_;
};

/// Up to three votes a point, each to the centre of a box that holds it, as VoteNet trains on.
std::vector<float> votes_of(const LabeledScene& scene) {
  std::vector<geometry::Box> boxes;
  for (const LabeledObject& object : scene.objects) boxes.push_back(object.box);
  const auto inside = points_in_boxes(scene.cloud.view(), boxes);
  std::vector<float> votes(scene.cloud.size() * kVoteColumns, 0.0F);
  std::vector<std::size_t> next(scene.cloud.size(), 0);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    for (const std::int32_t point : inside[b]) {
      float* row = votes.data() + static_cast<std::size_t>(point) * kVoteColumns;
      const Eigen::Vector3f vote =
          boxes[b].center.cast<float>() - scene.cloud.view().position(point);
      const std::size_t slot = next[point];
      row[0] = 1.0F;
      for (std::size_t s = slot; s < (slot == 0 ? 3 : slot + 1); ++s) {
        std::copy_n(vote.data(), 3, row + 1 + 3 * s);
      }
      next[point] = std::min<std::size_t>(2, slot + 1);
    }
  }
  return votes;
}

class SunVotenetWriter : public AccountingWriter {
 public:
  explicit SunVotenetWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kRoom,
                                  .boxes = BoxForm::kUpright,
                                  .classes = sunrgbd_class_names()}) {}

 private:
  void write(const std::string& split, const LabeledScene& scene) override {
    const Folder folder = root() / (kPrefix + std::string("50k_v1_") + split);
    make_folder(folder);
    const auto array = [](const std::vector<float>& values, std::size_t columns) {
      return encode_npy<float>(values, {values.size() / columns, columns});
    };
    write_file(folder / (scene.name + kCloud),
               encode_npz({{"pc", array(colored_rows(scene.cloud, 1.0F), 6)}}));
    if (!scene.labelled) return;
    std::vector<double> rows;
    for (const LabeledObject& object : scene.objects) {
      const geometry::Box& box = object.box;
      for (int i = 0; i < 3; ++i) rows.push_back(box.center[i]);
      for (int i = 0; i < 3; ++i) rows.push_back(0.5 * box.size[i]);
      rows.push_back(-geometry::yaw(box));
      rows.push_back(static_cast<double>(class_number(object)));
    }
    write_npy<double>(folder / (scene.name + "_bbox.npy"), rows,
                      {scene.objects.size(), kSunRgbdBoxColumns});
    write_file(folder / (scene.name + "_votes.npz"),
               encode_npz({{"point_votes", array(votes_of(scene), kVoteColumns)}}));
  }

  void write_rest() override {}
};

}  // namespace

bool fits_sunrgbd_votenet(const Folder& root) { return !split_folders(root).empty(); }

Reader open_sunrgbd_votenet(const Folder& root, const DatasetOptions&) {
  return std::make_unique<SunVotenetReader>(root);
}

Writer create_sunrgbd_votenet(const NewDataset& dataset) {
  return std::make_unique<SunVotenetWriter>(dataset.root);
}

}  // namespace arbox::io::internal
