#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/picture_output.h"
#include "arbox/cli/progress.h"
#include "arbox/cli/uncertainty_figure.h"
#include "arbox/drawing/image.h"
#include "arbox/evaluation/uncertainty_protocol.h"
#include "arbox/io/detection_json.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"

namespace arbox::cli {
namespace {

namespace fs = std::filesystem;
using geometry::Detection;
using Scans = std::map<std::string, std::vector<Detection>>;

struct UncertaintyFlags {
  fs::path labels, predictions, calibration;
  std::string measure = "told", json, plot;
  evaluation::UncertaintyOptions options{.min_score = 0.3};
};

std::vector<fs::path> files_in(const fs::path& folder, std::initializer_list<const char*> endings) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (std::find(endings.begin(), endings.end(), ending) != endings.end()) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

void add_scan(Scans& scans, const std::string& name, std::vector<Detection> detections,
              const fs::path& file) {
  if (!scans.emplace(name, std::move(detections)).second) {
    throw FormatError(file.string() + ": scan '" + name + "' stands twice");
  }
}

void add_json(Scans& scans, const fs::path& file) {
  for (io::ScanDetections& scan : io::read_detections_json(file)) {
    const std::string source = fs::path(scan.source).stem().string();
    add_scan(scans, source.empty() ? file.stem().string() : source, std::move(scan.detections),
             file);
  }
}

/// Detections or objects as JSON: a file of one or more scans, or a folder of such files.
Scans read_json_scans(const fs::path& path) {
  Scans scans;
  if (!fs::is_directory(path)) {
    add_json(scans, path);
    return scans;
  }
  const auto files = files_in(path, {".json", ".jsonl"});
  if (files.empty()) throw IoError(path.string() + ": holds no *.json or *.jsonl");
  Progress progress("read", static_cast<std::int64_t>(files.size()));
  for (const fs::path& file : files) {
    add_json(scans, file);
    progress.advance();
  }
  return scans;
}

/// The labels of the scans that there are detections of.
Scans read_kitti_scans(const fs::path& folder, const fs::path& calibration, const Scans& wanted) {
  if (calibration.empty()) {
    throw UsageError("--calib: KITTI labels need the folder of their calibrations");
  }
  Scans scans;
  for (const auto& [name, ignored] : wanted) {
    const fs::path file = name + ".txt";
    const fs::path frame = fs::is_directory(calibration) ? calibration / file : calibration;
    scans[name] =
        io::to_detections(io::read_kitti_labels(folder / file), io::read_kitti_calibration(frame));
  }
  return scans;
}

Scans read_labels(const UncertaintyFlags& flags, const Scans& predictions) {
  if (!fs::exists(flags.labels)) throw IoError(flags.labels.string() + ": no such file or folder");
  if (fs::is_directory(flags.labels) && files_in(flags.labels, {".json", ".jsonl"}).empty()) {
    return read_kitti_scans(flags.labels, flags.calibration, predictions);
  }
  return read_json_scans(flags.labels);
}

std::vector<evaluation::UncertaintyScan> read_scans(const UncertaintyFlags& flags) {
  if (!fs::exists(flags.predictions)) {
    throw IoError(flags.predictions.string() + ": no such file or folder");
  }
  Scans predictions = read_json_scans(flags.predictions);
  Scans labels = read_labels(flags, predictions);
  std::vector<evaluation::UncertaintyScan> scans;
  for (auto& [name, detections] : predictions) {
    const auto found = labels.find(name);
    if (found == labels.end()) {
      throw FormatError(flags.labels.string() + ": no labels of scan '" + name + "'");
    }
    if (flags.measure == "gaussian") evaluation::use_gaussian_uncertainty(detections);
    scans.push_back({.detections = std::move(detections), .objects = std::move(found->second)});
  }
  return scans;
}

void evaluate_uncertainty(const UncertaintyFlags& flags) {
  if (!flags.plot.empty()) require_picture("--plot", flags.plot);
  const auto report = evaluation::evaluate_uncertainty(read_scans(flags), flags.options);
  if (!flags.plot.empty()) drawing::write_image(draw_uncertainty(report), flags.plot);
  if (flags.json == "-") {
    std::cout << evaluation::to_json(report);
    return;
  }
  if (!flags.json.empty()) io::write_file(flags.json, evaluation::to_json(report));
  std::cout << evaluation::to_table(report);
}

}  // namespace

void add_evaluate_uncertainty(CLI::App& evaluate) {
  CLI::App* command = evaluate.add_subcommand(
      "uncertainty",
      "Whether boxes contain what they promise, and whether uncertainty tells good from bad ones");
  const auto flags = std::make_shared<UncertaintyFlags>();
  command
      ->add_option("--labels", flags->labels,
                   "Folder of KITTI labels NAME.txt, or objects as JSON, JSON lines or a folder "
                   "of these")
      ->type_name("PATH")
      ->required();
  command
      ->add_option("--predictions", flags->predictions,
                   "What 'arbox detect --quantile' wrote: .json, .jsonl or a folder of these")
      ->type_name("PATH")
      ->required();
  command
      ->add_option("--calib", flags->calibration,
                   "KITTI calibration of the labels, or a folder of NAME.txt")
      ->type_name("FILE|DIR");
  command->add_option("--classes", flags->options.classes, "Classes (default: all of the labels)")
      ->type_name("CLASS");
  command
      ->add_option("--score", flags->options.min_score, "Leave out detections with a lower score")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--distance", flags->options.max_distance,
                   "A detection found an object of its class if their centres are this near, "
                   "metres")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--min-iog", flags->options.min_iog,
                   "The share of the object that counts as containing it")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--wrong-iou", flags->options.wrong_iou,
                   "Boxes with a lower IoU are those that the uncertainty should tell")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--measure", flags->measure,
                   "told: each detection's own uncertainty; gaussian: deviation of the sampled "
                   "sizes (arbox detect --samples)")
      ->check(CLI::IsMember({"told", "gaussian"}))
      ->capture_default_str();
  command
      ->add_option("--sample-confidence", flags->options.sample_confidences,
                   "Score also boxes that hold the share P of a detection's own samples (arbox "
                   "detect --samples)")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--json", flags->json, "Write the report there; - for standard output")
      ->type_name("FILE");
  command
      ->add_option("--plot", flags->plot,
                   "Draw containment against promise, and IoU against uncertainty (PNG or JPEG)")
      ->type_name("FILE");
  add_examples(*command,
               {{"arbox detect velodyne --quantile 0.1 0.2 0.5 --format jsonl --output found",
                 "Detections with quantile boxes"},
                {"arbox evaluate uncertainty --labels label_2 --calib calib --predictions "
                 "found/detections.jsonl --plot promise.png",
                 "A table and a picture"}});
  command->callback([flags] { evaluate_uncertainty(*flags); });
}

}  // namespace arbox::cli
