#include <CLI/CLI.hpp>
#include <charconv>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/evaluation_figure.h"
#include "arbox/cli/picture_output.h"
#include "arbox/cli/progress.h"
#include "arbox/drawing/image.h"
#include "arbox/evaluation/indoor_files.h"
#include "arbox/evaluation/kitti_files.h"
#include "arbox/evaluation/report.h"
#include "arbox/io/file.h"

namespace arbox::cli {
namespace {

using evaluation::KittiClass;
using geometry::Overlap;

struct EvaluateFlags {
  std::string labels;
  std::string predictions;
  std::string split;
  std::string overlap = "iou";
  std::string birds_eye_overlap = "iou";
  std::vector<std::string> classes;
  std::vector<std::string> class_names;
  std::vector<std::string> min_overlaps;
  std::vector<double> thresholds = {0.25, 0.50};
  std::string json;
  std::string plot;
};

using SharedFlags = std::shared_ptr<EvaluateFlags>;

Overlap overlap_of(const std::string& name) {
  return name == "iog" ? Overlap::kIog : Overlap::kIou;
}

/// Numbers of "0.7" or "0.7,0.5,0.5" (2-D, bird's eye, 3-D).
std::optional<evaluation::KittiThresholds> parse_thresholds(std::string_view text) {
  std::vector<double> values;
  while (true) {
    const std::string_view word = text.substr(0, text.find(','));
    double value = -1.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    if (!(value >= 0.0 && value < 1.0)) return std::nullopt;
    values.push_back(value);
    if (word.size() == text.size()) break;
    text.remove_prefix(word.size() + 1);
  }
  if (values.size() == 1) return evaluation::KittiThresholds{values[0], values[0], values[0]};
  if (values.size() != 3) return std::nullopt;
  return evaluation::KittiThresholds{values[0], values[1], values[2]};
}

std::vector<KittiClass> kitti_classes(const EvaluateFlags& flags) {
  std::vector<std::string> names = flags.classes;
  if (names.empty()) names = {"Car", "Pedestrian", "Cyclist"};
  std::vector<KittiClass> classes;
  std::vector<bool> has_overlap;
  for (const std::string& name : names) {
    const auto known = evaluation::kitti_class(name);
    classes.push_back(known ? *known : KittiClass{name, {}, {}});
    has_overlap.push_back(known.has_value());
  }
  for (const std::string& text : flags.min_overlaps) {
    const std::size_t equals = text.find('=');
    const auto place = std::find(names.begin(), names.end(), text.substr(0, equals));
    if (equals == std::string::npos || place == names.end()) {
      throw UsageError("--min-overlap " + text +
                       ": expected CLASS=OVERLAP with a class that is evaluated");
    }
    const auto thresholds = parse_thresholds(std::string_view(text).substr(equals + 1));
    if (!thresholds) {
      throw UsageError("--min-overlap " + text +
                       ": expected one overlap, or three (2-D, bird's eye, 3-D), in [0, 1)");
    }
    const auto i = static_cast<std::size_t>(place - names.begin());
    classes[i].min_overlap = *thresholds;
    has_overlap[i] = true;
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!has_overlap[i]) {
      throw UsageError("the benchmark has no minimum overlap for class " + names[i] +
                       "; give one with --min-overlap " + names[i] + "=0.5");
    }
  }
  return classes;
}

template <class Report>
void give(const Report& report, const std::string& table, const EvaluateFlags& flags) {
  if (!flags.plot.empty()) {
    drawing::write_image(draw_precision_recall(report), flags.plot);
  }
  if (flags.json == "-") {
    std::cout << evaluation::to_json(report);
    return;
  }
  if (!flags.json.empty()) io::write_file(flags.json, evaluation::to_json(report));
  std::cout << table;
}

std::vector<evaluation::KittiFrame> read_kitti(const EvaluateFlags& flags,
                                               const std::optional<std::filesystem::path>& split) {
  const auto names = evaluation::kitti_frame_names(flags.predictions, split);
  Progress progress("read", static_cast<std::int64_t>(names.size()));
  return evaluation::read_kitti_frames(flags.labels, flags.predictions, split, 0,
                                       [&] { progress.advance(); })
      .frames;
}

evaluation::KittiReport score_kitti(const std::vector<evaluation::KittiFrame>& frames,
                                    const evaluation::KittiOptions& options) {
  Progress progress("score",
                    evaluation::kKittiCells * static_cast<std::int64_t>(options.classes.size()));
  return evaluation::evaluate_kitti(frames, options, [&] { progress.advance(); });
}

void evaluate_kitti(const EvaluateFlags& flags) {
  const evaluation::KittiOptions options = {
      .classes = kitti_classes(flags),
      .overlap = overlap_of(flags.overlap),
      .birds_eye_overlap = overlap_of(flags.birds_eye_overlap)};
  if (!flags.plot.empty()) require_picture("--plot", flags.plot);
  const auto split =
      flags.split.empty() ? std::nullopt : std::optional<std::filesystem::path>(flags.split);
  const auto frames = read_kitti(flags, split);
  const auto report = score_kitti(frames, options);
  give(report, evaluation::to_table(report), flags);
}

std::vector<evaluation::IndoorScene> read_indoor(const EvaluateFlags& flags) {
  Progress progress("read", evaluation::count_indoor_files(flags.labels, flags.predictions));
  return evaluation::read_indoor_scenes(flags.labels, flags.predictions, flags.class_names,
                                        [&] { progress.advance(); });
}

void evaluate_indoor(const EvaluateFlags& flags) {
  if (!flags.plot.empty()) require_picture("--plot", flags.plot);
  const auto scenes = read_indoor(flags);
  const auto report = evaluation::evaluate_indoor(scenes, {.thresholds = flags.thresholds,
                                                           .overlap = overlap_of(flags.overlap),
                                                           .classes = flags.classes});
  give(report, evaluation::to_table(report, flags.thresholds), flags);
}

void add_shared_flags(CLI::App& command, EvaluateFlags& flags) {
  command
      .add_option("--overlap", flags.overlap,
                  "iou, or iog: intersection over the true box, in the 3-D metric")
      ->check(CLI::IsMember({"iou", "iog"}))
      ->capture_default_str();
  command.add_option("--json", flags.json, "Write the report there; - for standard output")
      ->type_name("FILE");
  command.add_option("--plot", flags.plot, "Draw the precision-recall curves (PNG or JPEG)")
      ->type_name("FILE");
}

void add_kitti(CLI::App& evaluate, const SharedFlags& flags) {
  CLI::App* command = evaluate.add_subcommand(
      "kitti", "Average precision of KITTI result files, as the official kit computes it");
  command->add_option("--labels", flags->labels, "Folder of label files NAME.txt")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--predictions", flags->predictions,
                   "Folder of result files NAME.txt; an empty file means that nothing was found")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--split", flags->split,
                   "File with the names of the frames (default: every result file)")
      ->type_name("FILE");
  command->add_option("--classes", flags->classes, "Classes (default: Car Pedestrian Cyclist)")
      ->type_name("CLASS");
  command
      ->add_option("--min-overlap", flags->min_overlaps,
                   "Overlap that a match must exceed: in all metrics, or in 2-D, bird's eye, 3-D")
      ->type_name("CLASS=T|CLASS=T,T,T");
  command->add_option("--bev-overlap", flags->birds_eye_overlap, "iou or iog in bird's eye")
      ->check(CLI::IsMember({"iou", "iog"}))
      ->capture_default_str();
  add_shared_flags(*command, *flags);
  add_examples(*command,
               {{"arbox evaluate kitti --labels label_2 --predictions results", "A table"},
                {"arbox evaluate kitti --labels label_2 --predictions results --split val.txt "
                 "--overlap iog --json report.json --plot curves.png",
                 "IoG in 3-D; a report and a picture"},
                {"arbox evaluate kitti --labels label_2 --predictions results --classes Car Tram "
                 "--min-overlap Car=0.7,0.5,0.5 --min-overlap Tram=0.5",
                 "Other classes and overlaps"}});
  command->callback([flags] { evaluate_kitti(*flags); });
}

void add_indoor(CLI::App& evaluate, const SharedFlags& flags) {
  CLI::App* command = evaluate.add_subcommand(
      "indoor", "Average precision of boxes in rooms, as VoteNet and mmdetection3d compute it");
  const char* const forms =
      "detections as .json or .jsonl, or a folder of these, of .csv box "
      "tables, or of VoteNet's *_map_cls.txt";
  command->add_option("--labels", flags->labels, std::string("Truth: ") + forms)
      ->type_name("PATH")
      ->required();
  command->add_option("--predictions", flags->predictions, std::string("Predictions: ") + forms)
      ->type_name("PATH")
      ->required();
  command
      ->add_option("--thresholds", flags->thresholds,
                   "Overlaps of the table's columns; the mean over .05 to .95 comes always")
      ->check(CLI::Range(0.0, 0.999999))
      ->capture_default_str();
  command->add_option("--classes", flags->classes, "Classes (default: all of the truth)")
      ->type_name("CLASS");
  command
      ->add_option("--class-names", flags->class_names,
                   "Names of the class numbers 0, 1, ... in VoteNet's files")
      ->type_name("NAME");
  add_shared_flags(*command, *flags);
  add_examples(*command,
               {{"arbox evaluate indoor --labels truth.jsonl --predictions found.jsonl", "A table"},
                {"arbox evaluate indoor --labels dump --predictions dump --class-names bed table "
                 "sofa --json -",
                 "VoteNet's dumped files; JSON on standard output"}});
  command->callback([flags] { evaluate_indoor(*flags); });
}

}  // namespace

void add_evaluate(CLI::App& app) {
  CLI::App* evaluate = app.add_subcommand("evaluate", "Score detections against labels");
  evaluate->require_subcommand(1);
  add_kitti(*evaluate, std::make_shared<EvaluateFlags>());
  add_indoor(*evaluate, std::make_shared<EvaluateFlags>());
  add_evaluate_boxes(*evaluate);
  add_evaluate_uncertainty(*evaluate);
  add_examples(*evaluate,
               {{"arbox evaluate kitti --labels label_2 --predictions results", "KITTI protocol"},
                {"arbox evaluate indoor --labels truth.jsonl --predictions found.jsonl",
                 "Indoor protocol"}});
}

}  // namespace arbox::cli
