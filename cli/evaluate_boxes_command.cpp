#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/evaluation/box_estimation.h"
#include "arbox/io/box_table.h"
#include "arbox/io/file.h"

namespace arbox::cli {
namespace {

struct EvaluateBoxesFlags {
  std::string labels, predictions, symmetry = "frame", json;
  double min_iog = evaluation::kContainedIog;
};

geometry::BoxSymmetry symmetry_of(const std::string& name) {
  if (name == "none") return geometry::BoxSymmetry::kNone;
  return name == "half-turns" ? geometry::BoxSymmetry::kHalfTurns : geometry::BoxSymmetry::kFrame;
}

/// The predictions in the order of the truth: by the column `object` where both have one, else as
/// they stand.
std::vector<geometry::Box> in_order(const io::BoxTable& predictions, const io::BoxTable& truth,
                                    const EvaluateBoxesFlags& flags) {
  if (predictions.objects.empty() || truth.objects.empty()) return predictions.boxes;
  std::map<std::int64_t, std::size_t> rows;
  for (std::size_t i = 0; i < predictions.objects.size(); ++i) {
    if (!rows.emplace(predictions.objects[i], i).second) {
      throw FormatError(flags.predictions + ": expected one box an object, got a second one of " +
                        std::to_string(predictions.objects[i]));
    }
  }
  std::vector<geometry::Box> boxes;
  for (const std::int64_t object : truth.objects) {
    const auto found = rows.find(object);
    if (found == rows.end()) {
      throw FormatError(flags.predictions + ": expected a box of object " + std::to_string(object) +
                        ", got none");
    }
    boxes.push_back(predictions.boxes[found->second]);
  }
  return boxes;
}

void evaluate_boxes(const EvaluateBoxesFlags& flags) {
  const io::BoxTable truth = io::read_box_table(flags.labels);
  const io::BoxTable predictions = io::read_box_table(flags.predictions);
  const auto report = evaluation::evaluate_boxes(
      in_order(predictions, truth, flags), truth.boxes,
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
  command->add_option("--labels", flags->labels, "True boxes, CSV")->type_name("FILE")->required();
  command
      ->add_option("--predictions", flags->predictions,
                   "Estimated boxes, CSV: row by row, or matched by the column object")
      ->type_name("FILE")
      ->required();
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
                           "Means over all objects"}});
  command->callback([flags] { evaluate_boxes(*flags); });
}

}  // namespace arbox::cli
