#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/labelled_scans.h"
#include "arbox/cli/progress.h"
#include "arbox/detectors/open_detector.h"
#include "arbox/evaluation/center_matching.h"
#include "arbox/evaluation/confidence_calibration.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/model_archive.h"
#include "arbox/io/model_search.h"

namespace arbox::cli {
namespace {

struct CalibrateFlags {
  std::string model;
  std::filesystem::path data;
  std::string split = "val";
  std::filesystem::path output;
  std::string source;
  bool all_round = false;
  double max_distance = 2.0;
  detectors::DetectionRequest request{.score = 0.3, .samples = true};
  evaluation::CalibrationOptions calibration;
};

struct FoundObject {
  std::string label;
  std::vector<geometry::Box> samples;
  geometry::Box truth;
};

std::vector<FoundObject> found_objects(const CalibrateFlags& flags,
                                       const detectors::Detector& detector,
                                       const io::KittiDataset& dataset,
                                       const std::vector<std::string>& frames) {
  std::vector<FoundObject> found;
  Progress progress("calibrate", static_cast<std::int64_t>(frames.size()));
  for (const std::string& frame : frames) {
    const io::KittiPaths paths = dataset.paths(flags.split, frame);
    const auto objects = labelled_objects(paths, flags.all_round);
    const geometry::PointCloud cloud = io::read_kitti_scan(paths.scan);
    auto detections = detector.detect(cloud.view(), flags.request).detections;
    for (const auto& match : evaluation::match_by_center(detections, objects, flags.max_distance)) {
      geometry::Detection& detection = detections[match.detection];
      if (detection.samples.empty()) {
        throw Error(
            "calibrate: this model's head gives one box and no distribution; choose one "
            "that does, for example the autoregressive head");
      }
      found.push_back(
          {std::move(detection.label), std::move(detection.samples), objects[match.object].box});
    }
    progress.advance();
  }
  return found;
}

std::vector<evaluation::CalibrationObject> calibration_objects(
    const std::vector<FoundObject>& found) {
  std::vector<evaluation::CalibrationObject> objects;
  objects.reserve(found.size());
  for (const FoundObject& object : found) {
    objects.push_back({.label = object.label,
                       .samples = {.boxes = object.samples, .object = objects.size()},
                       .truth = object.truth});
  }
  return objects;
}

std::string default_source(const CalibrateFlags& flags, std::size_t frames) {
  const auto folder = std::filesystem::weakly_canonical(flags.data);
  return folder.filename().string() + ", split " + flags.split + ", " + std::to_string(frames) +
         " scans" + (flags.all_round ? ", all round" : "") + ", scores from " +
         std::to_string(flags.request.score).substr(0, 4);
}

void calibrate(const CalibrateFlags& flags) {
  const std::filesystem::path file = io::find_model(flags.model);
  io::ModelArchive archive = io::read_model_archive(file);
  const auto detector = detectors::open_model(file.string(), {"post.score=0"});
  const io::KittiDataset dataset = io::KittiDataset::open(flags.data);
  const std::vector<std::string> frames = dataset.frames(flags.split);
  const auto found = found_objects(flags, *detector, dataset, frames);
  if (found.empty()) {
    throw Error("calibrate: the model found none of the labelled objects of " +
                std::to_string(frames.size()) +
                " scans; lower --score, or look at its boxes with "
                "'arbox detect --view'");
  }
  const auto calibration = evaluation::calibrate_confidence(
      calibration_objects(found),
      flags.source.empty() ? default_source(flags, frames.size()) : flags.source,
      flags.calibration);
  archive.calibration = evaluation::to_json(calibration);
  io::write_model_archive(flags.output, archive, true);
  for (const auto& [label, extents] : calibration.classes) {
    std::printf("%-20s%8lld objects\n", label.c_str(),
                static_cast<long long>(calibration.objects(label)));
  }
  std::printf("model               %s\n", flags.output.c_str());
}

}  // namespace

void add_calibrate(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Give a model confidence boxes that keep their promise: from labelled scans that it was not "
      "trained on, how large they must be to contain the object with the probability asked for");
  const auto flags = std::make_shared<CalibrateFlags>();
  command->add_option("model", flags->model, "A .arbox file, or the name of an installed model")
      ->required()
      ->type_name("MODEL");
  command->add_option("--data", flags->data, "Labelled scans in KITTI's layout")
      ->required()
      ->check(CLI::ExistingDirectory)
      ->type_name("ROOT");
  command->add_option("--split", flags->split, "Split of the scans")->capture_default_str();
  command->add_option("-o,--output", flags->output, "The model to write; may be the same file")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--source", flags->source,
                   "What the scans are, for those who read 'arbox info' (default: folder, split "
                   "and number)")
      ->type_name("TEXT");
  command->add_flag("--all-round", flags->all_round,
                    "Also the objects that the camera does not see, of ROOT/training/label_360, as "
                    "'arbox simulate street' writes them");
  command
      ->add_option("--score", flags->request.score,
                   "Objects found with a lower score are left out; detect with the same or a "
                   "higher one")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--distance", flags->max_distance,
                   "A detection found an object of its class if their centres are this near, "
                   "metres")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--iog", flags->calibration.min_iog,
                   "The share of the object that counts as containing it")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--seed", flags->request.seed, "Seed of the box samples")
      ->capture_default_str();
  add_examples(*command,
               {{"arbox calibrate car.arbox --data /data/kitti --split val --output car.arbox",
                 "On scans of the sensor and the places that the model will be used in"},
                {"arbox detect scan.pcd --model car.arbox --confidence 0.9",
                 "Boxes that contain the object with probability 0.9"}});
  command->callback([flags] { calibrate(*flags); });
}

}  // namespace arbox::cli
