#include "arbox/cli/detection_output.h"

#include <algorithm>
#include <iostream>
#include <map>
#include <utility>

#include "arbox/cli/command_line.h"
#include "arbox/cli/picture_output.h"
#include "arbox/drawing/color.h"
#include "arbox/drawing/image.h"
#include "arbox/drawing/scene.h"
#include "arbox/io/box_table.h"
#include "arbox/io/file.h"
#include "arbox/io/image_size.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/kitti_label.h"
#include "arbox/io/wireframe.h"

namespace arbox::cli {
namespace {

std::string extension_of(const std::string& format) { return format == "kitti" ? "txt" : format; }

void require_different_names(const std::vector<ScanInput>& scans) {
  std::map<std::string, std::string> seen;
  for (const auto& [scan, calibration, image] : scans) {
    const auto [entry, is_new] = seen.emplace(scan_name(scan), scan);
    if (is_new) continue;
    throw UsageError(entry->second + " and " + scan + " would be written to files of one name: " +
                     "run them apart, or use --format jsonl");
  }
}

}  // namespace

std::string scan_name(const std::string& source) {
  return source == "-" ? "stdin" : std::filesystem::path(source).stem().string();
}

DetectionOutput::DetectionOutput(OutputOptions options, const std::vector<ScanInput>& scans,
                                 bool several)
    : options_(std::move(options)), several_(several) {
  const bool one_text = options_.format == "json" || options_.format == "jsonl";
  if (several_ && options_.folder.empty() && !one_text) {
    throw UsageError("several scans do not fit into one " + options_.format +
                     " text: give --output DIR");
  }
  if (!options_.calibration.empty() && options_.format != "kitti") {
    throw UsageError("--calib is for --format kitti");
  }
  if (several_ && options_.view.has_extension()) {
    throw UsageError("--view names a folder when there are several scans, got " +
                     options_.view.string());
  }
  if (!several_ && !options_.view.empty()) require_picture("--view", options_.view);
  const bool file_a_scan = !options_.folder.empty() && options_.format != "jsonl";
  if (file_a_scan || (several_ && !options_.view.empty())) require_different_names(scans);
  const auto make = [](const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw IoError(folder.string() + ": cannot be made: " + error.message());
  };
  if (!options_.folder.empty()) make(options_.folder);
  if (several_ && !options_.view.empty()) make(options_.view);
}

void DetectionOutput::write(const ScanInput& input, std::vector<geometry::Detection> detections,
                            const geometry::PointCloudView& cloud) {
  const io::ScanDetections scan{.source = input.source, .detections = std::move(detections)};
  if (!options_.view.empty()) draw(scan, cloud);
  const std::string content = text(input, scan);
  if (options_.folder.empty()) {
    if (several_ && options_.format == "json") std::cout << (written_ == 0 ? "[\n" : ",\n");
    std::cout << content;
    if (options_.format == "json") std::cout << (several_ ? "" : "\n");
    std::cout.flush();
  } else if (options_.format == "jsonl") {
    lines_ += content;
  } else {
    io::write_file(options_.folder / (scan_name(scan.source) + "." + extension_of(options_.format)),
                   content + (options_.format == "json" ? "\n" : ""));
  }
  ++written_;
}

void DetectionOutput::finish() {
  if (options_.folder.empty()) {
    if (several_ && options_.format == "json") std::cout << (written_ == 0 ? "[]\n" : "\n]\n");
  } else if (options_.format == "jsonl") {
    io::write_file(options_.folder / "detections.jsonl", lines_);
  }
}

std::string DetectionOutput::text(const ScanInput& input, const io::ScanDetections& scan) const {
  if (options_.format == "json") return io::format_detections_json(scan, several_ ? -1 : 2);
  if (options_.format == "jsonl") return io::format_detections_json(scan) + "\n";
  if (options_.format == "csv") return io::format_box_table(io::to_box_table(scan.detections));
  if (options_.format == "ply") {
    return io::format_wireframes_ply(scan.detections, [](std::string_view label) {
      const drawing::Color color = drawing::class_color(label);
      return io::RgbBytes{color.r, color.g, color.b};
    });
  }
  return kitti_text(input, scan);
}

std::string DetectionOutput::kitti_text(const ScanInput& input,
                                        const io::ScanDetections& scan) const {
  std::filesystem::path file = options_.calibration;
  if (file.empty()) file = input.calibration;
  if (file.empty()) return io::format_kitti_results(io::to_kitti_results(scan.detections));
  if (std::filesystem::is_directory(file)) file /= scan_name(scan.source) + ".txt";
  const io::KittiCalibration calibration = io::read_kitti_calibration(file);
  const io::ImageSize image = std::filesystem::exists(input.image)
                                  ? io::read_png_size(input.image)
                                  : io::known_image_size(calibration).value_or(io::kUsualImageSize);
  return io::format_kitti_results(io::to_kitti_results(scan.detections, calibration, image));
}

void DetectionOutput::draw(const io::ScanDetections& scan,
                           const geometry::PointCloudView& cloud) const {
  const drawing::Scene scene{
      .cloud = cloud, .predictions = scan.detections, .truth = {}, .photo = {}};
  const std::string name = scan_name(scan.source);
  const drawing::Image image = drawing::draw_scene(scene, {.title = name});
  drawing::write_image(image, several_ ? options_.view / (name + ".png") : options_.view);
}

}  // namespace arbox::cli
