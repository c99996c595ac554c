#include "arbox/io/kitti_dataset.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <unordered_set>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/kitti_label.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytesPerPoint = 16;
constexpr std::string_view kTraining = "training";
constexpr std::string_view kTesting = "testing";

bool is_frame_name(std::string_view name) {
  return !name.starts_with('.') && std::all_of(name.begin(), name.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '-' || letter == '.';
  });
}

void add_stems(const fs::path& folder, std::string_view extension, std::set<std::string>& names) {
  if (!fs::is_directory(folder)) return;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) names.insert(entry.path().stem().string());
  }
}

std::vector<std::string> frames_in(const fs::path& folder) {
  std::set<std::string> names;
  add_stems(folder / "velodyne", ".bin", names);
  add_stems(folder / "label_2", ".txt", names);
  add_stems(folder / "calib", ".txt", names);
  add_stems(folder / "image_2", ".png", names);
  return {names.begin(), names.end()};
}

void require_whole_points(const fs::path& path, std::uintmax_t bytes) {
  if (bytes != 0 && bytes % kBytesPerPoint == 0) return;
  throw FormatError(path.string() +
                    ": expected rows of four float32 numbers (a multiple of 16 bytes, above 0), "
                    "got " +
                    std::to_string(bytes) + " bytes");
}

}  // namespace

std::vector<std::string> parse_kitti_split(std::string_view text, std::string_view source) {
  std::vector<std::string> names;
  std::unordered_set<std::string_view> seen;
  internal::LineReader lines(text, source);
  while (lines.next_filled()) {
    const std::string_view name = internal::trimmed(lines.line());
    if (!is_frame_name(name)) {
      internal::refuse(lines.place(), "one frame name a line (such as 000042)",
                       internal::quoted_text(name));
    }
    if (!seen.insert(name).second) {
      internal::refuse(lines.place(), "each frame once",
                       internal::quoted_text(name) + " a second time");
    }
    names.emplace_back(name);
  }
  return names;
}

std::vector<std::string> read_kitti_split(const fs::path& path) {
  return parse_kitti_split(read_file(path), path.string());
}

geometry::PointCloud read_kitti_scan(const fs::path& path) {
  count_kitti_points(path);
  return read_point_cloud(path, {.channels = {"x", "y", "z", "intensity"},
                                 .keep_non_finite = true,
                                 .scale_intensity = false,
                                 .format = "bin"})
      .points;
}

std::int64_t count_kitti_points(const fs::path& path) {
  // Refuses what is missing or no file.
  read_file(path, 0);
  const std::uintmax_t bytes = fs::file_size(path);
  require_whole_points(path, bytes);
  return static_cast<std::int64_t>(bytes / kBytesPerPoint);
}

KittiDataset KittiDataset::open(const fs::path& root) {
  if (!fs::is_directory(root)) {
    throw IoError(root.string() + ": expected the root folder of a KITTI data set, got " +
                  (fs::exists(root) ? "a file" : "a path that does not exist"));
  }
  if (!fs::is_directory(root / kTraining) && !fs::is_directory(root / kTesting)) {
    const bool inside = fs::is_directory(root / "velodyne") || fs::is_directory(root / "label_2");
    throw IoError(root.string() + ": expected a folder with training or testing in it, got one " +
                  (inside ? "with frames; give its parent folder" : "without"));
  }
  return KittiDataset(root);
}

std::vector<std::string> KittiDataset::splits() const {
  std::set<std::string> listed;
  add_stems(root_ / "ImageSets", ".txt", listed);
  std::vector<std::string> names(listed.begin(), listed.end());
  for (const std::string_view whole : {kTraining, kTesting}) {
    if (fs::is_directory(root_ / whole) && !listed.contains(std::string(whole))) {
      names.emplace_back(whole);
    }
  }
  return names;
}

std::vector<std::string> KittiDataset::frames(std::string_view split) const {
  const auto known = splits();
  if (std::find(known.begin(), known.end(), split) == known.end()) {
    throw InvalidArgument(root_.string() + ": expected one of the splits " +
                          internal::joined(known, ", ") + ", got " + internal::quoted_text(split));
  }
  const fs::path list = root_ / "ImageSets" / (std::string(split) + ".txt");
  return fs::exists(list) ? read_kitti_split(list) : frames_in(root_ / split);
}

std::string_view KittiDataset::folder(std::string_view split) {
  return split == "test" || split == kTesting ? kTesting : kTraining;
}

KittiPaths KittiDataset::paths(std::string_view split, std::string_view id) const {
  const fs::path base = root_ / folder(split);
  const std::string name(id);
  return {.scan = base / "velodyne" / (name + ".bin"),
          .label = base / "label_2" / (name + ".txt"),
          .calibration = base / "calib" / (name + ".txt"),
          .image = base / "image_2" / (name + ".png"),
          .plane = base / "planes" / (name + ".txt")};
}

KittiFrame KittiDataset::load(std::string_view split, std::string_view id) const {
  const KittiPaths files = paths(split, id);
  KittiFrame frame;
  frame.id = id;
  frame.cloud = read_kitti_scan(files.scan);
  frame.calibration = read_kitti_calibration(files.calibration);
  if (folder(split) == kTraining) frame.labels = read_kitti_labels(files.label);
  if (fs::exists(files.plane)) frame.plane = read_kitti_plane(files.plane);
  if (fs::exists(files.image)) {
    frame.image = files.image;
    frame.image_size = read_png_size(files.image);
  } else {
    frame.image_size = known_image_size(frame.calibration);
  }
  return frame;
}

}  // namespace arbox::io
