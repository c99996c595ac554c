#include "arbox/simulation/street_dataset.h"

#include <atomic>
#include <bit>
#include <cstdio>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/parallel.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_label.h"

namespace arbox::simulation {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMostScenes = 1000000;
constexpr const char* kFolders[] = {"velodyne", "label_2", "label_360", "calib", "planes"};
constexpr const char* kImages = "image_2";

std::string frame_name(std::int64_t index) {
  char text[32];
  std::snprintf(text, sizeof text, "%06lld", static_cast<long long>(index));
  return text;
}

std::string plane_text(const io::KittiPlane& plane) {
  char text[160];
  std::snprintf(text, sizeof text, "# Plane\nWIDTH 4\nHEIGHT 1\n%.6e %.6e %.6e %.6e\n",
                plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset);
  return text;
}

std::string scan_bytes(const geometry::PointCloud& cloud) {
  static_assert(std::endian::native == std::endian::little);
  return {reinterpret_cast<const char*>(cloud.values.data()), cloud.values.size() * sizeof(float)};
}

void write_frame(const StreetScan& scan, const StreetDatasetOptions& options,
                 const fs::path& training, const std::string& name) {
  const auto file = [&](const char* folder, const char* extension) {
    return training / folder / (name + extension);
  };
  io::write_file(file("label_2", ".txt"), io::format_kitti_labels(scan.labels.image));
  io::write_file(file("label_360", ".txt"), io::format_kitti_labels(scan.labels.around));
  io::write_file(file("calib", ".txt"), io::format_kitti_calibration(scan.camera.calibration));
  io::write_file(file("planes", ".txt"), plane_text(ground_plane(scan.scene, scan.camera)));
  if (options.images) {
    const CameraImage image = render_camera_image(scan.scene, scan.camera, options.image);
    io::write_file(file(kImages, ".png"), drawing::encode_png(image.picture));
  }
  io::write_file(file("velodyne", ".bin"), scan_bytes(scan.cloud()));
}

/// What a run that was killed left half-written.
void remove_parts(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension().string().starts_with(".part")) fs::remove(entry.path());
  }
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw IoError(folder.string() + ": cannot be made: " + error.message());
  remove_parts(folder);
}

/// Without pictures this says nothing of them, as folders written before pictures were known.
std::string manifest_of(const StreetDatasetOptions& options, std::uint64_t seed) {
  const StreetScanOptions& scans = options;
  return "# arbox simulate street\n# seed: " + std::to_string(seed) + "\n" +
         (options.images ? options_yaml(options) : options_yaml(scans));
}

void begin(const fs::path& output, const std::string& manifest, bool images) {
  for (const char* folder : kFolders) make_folder(output / "training" / folder);
  if (images) make_folder(output / "training" / kImages);
  make_folder(output / "ImageSets");
  const fs::path path = output / "simulation.yaml";
  if (!fs::exists(path)) {
    io::write_file(path, manifest);
  } else if (io::read_file(path) != manifest) {
    throw ConfigError(path.string() +
                      ": expected the seed and the options of this run, got others; write into "
                      "another folder or remove this one");
  }
}

void write_splits(const fs::path& output, std::int64_t scenes) {
  std::string train, val, all;
  for (std::int64_t i = 0; i < scenes; ++i) {
    const std::string line = frame_name(i) + "\n";
    (i % 2 == 0 ? train : val) += line;
    all += line;
  }
  io::write_file(output / "ImageSets" / "train.txt", train);
  io::write_file(output / "ImageSets" / "val.txt", val);
  io::write_file(output / "ImageSets" / "trainval.txt", all);
}

}  // namespace

StreetDatasetReport write_street_dataset(const StreetDatasetOptions& options, std::uint64_t seed,
                                         std::int64_t scenes, const fs::path& output, int threads,
                                         const std::function<void()>& progress) {
  if (scenes < 1 || scenes > kMostScenes) {
    throw InvalidArgument("write_street_dataset: expected 1 to 1000000 scenes, got " +
                          std::to_string(scenes));
  }
  validate_options(options, "street dataset options");
  begin(output, manifest_of(options, seed), options.images);
  const fs::path training = output / "training";
  std::atomic<std::int64_t> written = 0;
  parallel_for(scenes, 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const std::string name = frame_name(i);
      if (!fs::exists(training / "velodyne" / (name + ".bin"))) {
        write_frame(street_scan(options, seed, static_cast<std::uint64_t>(i)), options, training,
                    name);
        ++written;
      }
      if (progress) progress();
    }
  });
  write_splits(output, scenes);
  return {.written = written, .found = scenes - written};
}

}  // namespace arbox::simulation
