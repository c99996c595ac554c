#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "arbox/cli/box_file.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/evaluation/box_estimation.h"
#include "arbox/io/box_table.h"
#include "arbox/io/detection_json.h"
#include "arbox/io/file.h"
#include "arbox/io/json.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/label_file.h"

namespace arbox::cli {
namespace {

struct EvaluateBoxesFlags {
  std::string labels, predictions, calibration, symmetry = "frame", json;
  double min_iog = evaluation::kContainedIog;
};

geometry::BoxSymmetry symmetry_of(const std::string& name) {
  if (name == "none") return geometry::BoxSymmetry::kNone;
  return name == "half-turns" ? geometry::BoxSymmetry::kHalfTurns : geometry::BoxSymmetry::kFrame;
}

/// Boxes of a file, with what tells which object each is.
struct BoxList {
  std::filesystem::path path;
  std::vector<geometry::Box> boxes;
  /// The column `object`, one a box; empty without one.
  std::vector<std::int64_t> objects;
  /// Names of the scans that the boxes stand in, one a box; empty if the file holds one scan.
  std::vector<std::string> scans;
};

void append(BoxList& list, const std::string& source, const std::vector<geometry::Box>& boxes) {
  list.boxes.insert(list.boxes.end(), boxes.begin(), boxes.end());
  list.scans.insert(list.scans.end(), boxes.size(), std::filesystem::path(source).stem().string());
}

std::vector<geometry::Box> boxes_of(const auto& found) {
  std::vector<geometry::Box> boxes;
  boxes.reserve(found.size());
  for (const auto& one : found) boxes.push_back(one.box);
  return boxes;
}

BoxList read_json(const std::filesystem::path& path) {
  BoxList list{.path = path, .boxes = {}, .objects = {}, .scans = {}};
  const std::string text = io::read_file(path), source = path.string();
  const auto values = io::parse_json_values(text, source);
  if (values.size() == 1 && values[0].is_object() && values[0].contains("objects")) {
    list.boxes = boxes_of(io::parse_label_json(text, source).objects);
    return list;
  }
  const auto scans = io::parse_detections_json(text, source);
  for (const auto& scan : scans) append(list, scan.source, boxes_of(scan.detections));
  if (scans.size() < 2) list.scans.clear();
  return list;
}

BoxList read_list(const std::filesystem::path& path, KittiText kitti,
                  const std::optional<io::KittiCalibration>& calibration) {
  BoxList list{.path = path, .boxes = {}, .objects = {}, .scans = {}};
  const std::string extension = path.extension().string();
  if (extension == ".json" || extension == ".jsonl") return read_json(path);
  if (extension == ".txt" && !calibration) {
    list.boxes = boxes_of(io::read_label_file(path).objects);
  } else if (extension == ".txt") {
    list.boxes = boxes_of(read_boxes(path, kitti, "", calibration));
  } else {
    io::BoxTable table = io::read_box_table(path);
    list.boxes = std::move(table.boxes);
    list.objects = std::move(table.objects);
  }
  return list;
}

/// For each box its key and how many of that key came before.
template <class Key>
std::map<std::pair<Key, std::size_t>, std::size_t> rows_by(const std::vector<Key>& keys) {
  std::map<std::pair<Key, std::size_t>, std::size_t> rows;
  std::map<Key, std::size_t> seen;
  for (std::size_t i = 0; i < keys.size(); ++i) rows[{keys[i], seen[keys[i]]++}] = i;
  return rows;
}

template <class Key>
std::vector<geometry::Box> matched(const BoxList& predictions, const std::vector<Key>& keys,
                                   const std::vector<Key>& wanted, const std::string& what) {
  const auto name = [](const Key& key) {
    if constexpr (std::is_integral_v<Key>) return std::to_string(key);
    if constexpr (!std::is_integral_v<Key>) return key;
  };
  auto rows = rows_by(keys);
  std::vector<geometry::Box> boxes(wanted.size());
  for (const auto& [key, row] : rows_by(wanted)) {
    const auto found = rows.find(key);
    if (found == rows.end()) {
      throw FormatError(predictions.path.string() + ": expected a box of " + what +
                        name(key.first) + ", got none" +
                        (key.second == 0 ? "" : " for its box " + std::to_string(key.second + 1)));
    }
    boxes[row] = predictions.boxes[found->second];
    rows.erase(found);
  }
  if (!rows.empty()) {
    throw FormatError(predictions.path.string() + ": expected one box an object, got one more of " +
                      what + name(rows.begin()->first.first));
  }
  return boxes;
}

/// The predictions in the order of the truth: by the column `object` where both have one, by scans
/// where both hold several, else as they stand.
std::vector<geometry::Box> in_order(const BoxList& predictions, const BoxList& truth) {
  if (!predictions.objects.empty() && !truth.objects.empty()) {
    return matched(predictions, predictions.objects, truth.objects, "object ");
  }
  if (!predictions.scans.empty() && !truth.scans.empty()) {
    return matched(predictions, predictions.scans, truth.scans, "scan ");
  }
  if (predictions.boxes.size() != truth.boxes.size()) {
    throw FormatError(predictions.path.string() + ": expected one box for each of the " +
                      std::to_string(truth.boxes.size()) + " in " + truth.path.string() + ", got " +
                      std::to_string(predictions.boxes.size()));
  }
  return predictions.boxes;
}

void evaluate_boxes(const EvaluateBoxesFlags& flags) {
  std::optional<io::KittiCalibration> calibration;
  if (!flags.calibration.empty()) {
    calibration = io::read_kitti_calibration(flags.calibration);
  }
  const BoxList truth = read_list(flags.labels, KittiText::kLabels, calibration);
  const BoxList predictions = read_list(flags.predictions, KittiText::kResults, calibration);
  const auto report = evaluation::evaluate_boxes(
      in_order(predictions, truth), truth.boxes,
      {.symmetry = symmetry_of(flags.symmetry), .min_iog = flags.min_iog});
  if (flags.json != "-") std::cout << evaluation::to_table(report);
  if (flags.json == "-") std::cout << evaluation::to_json(report);
  if (!flags.json.empty() && flags.json != "-") {
    io::write_file(flags.json, evaluation::to_json(report));
  }
}

}  // namespace

void add_evaluate_boxes(CLI::App& evaluate) {
  CLI::App* command = evaluate.add_subcommand(
      "boxes", "Errors of estimated boxes whose objects are known: IoU, IoG, F1, sizes, rotation");
  const auto flags = std::make_shared<EvaluateBoxesFlags>();
  command
      ->add_option("--labels", flags->labels,
                   "True boxes: CSV, detections or labels as JSON, JSON lines, label text, "
                   "or KITTI labels")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--predictions", flags->predictions,
                   "Estimated boxes in any of these forms (KITTI: results): one after another, or "
                   "matched by the column object of CSV or by the scans of JSON")
      ->type_name("FILE")
      ->required();
  command->add_option("--calib", flags->calibration, "KITTI calibration of .txt files in its form")
      ->type_name("FILE");
  command
      ->add_option("--symmetry", flags->symmetry,
                   "Which renamings of a box's axes count as the same rotation: all 24, the 4 half "
                   "turns, or none")
      ->check(CLI::IsMember({"frame", "half-turns", "none"}))
      ->capture_default_str();
  command->add_option("--min-iog", flags->min_iog, "IoG above which a box contains its object")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--json", flags->json, "Write the report there; - for standard output")
      ->type_name("FILE");
  add_examples(*command, {{"arbox evaluate boxes --labels truth.csv --predictions found.csv",
                           "Means over all objects"},
                          {"arbox evaluate boxes --labels labels/first.json --predictions "
                           "first.json --json report.json",
                           "What arbox detect wrote, against labels of your own"}});
  command->callback([flags] { evaluate_boxes(*flags); });
}

}  // namespace arbox::cli
