#include <CLI/CLI.hpp>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/torch_module.h"
#include "arbox/io/box_table.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/kitti_label.h"

namespace arbox::cli {
namespace {

struct FitBinsFlags {
  std::vector<std::filesystem::path> inputs;
  std::string split = "training";
  std::vector<std::string> classes;
  std::vector<std::string> codec;
  std::string kind = "residual";
  int draws = 8;
  std::uint64_t seed = 0;
  bool json = false;
};

class Collector {
 public:
  explicit Collector(const FitBinsFlags& flags)
      : flags_(flags), classes_(flags.classes.begin(), flags.classes.end()) {}

  void add(const std::filesystem::path& input) {
    if (std::filesystem::is_directory(input)) {
      add_kitti(io::KittiDataset::open(input));
    } else {
      add_table(io::read_box_table(input), input);
    }
  }

  std::vector<geometry::Box> boxes;

 private:
  bool wanted(const std::string& name) const { return classes_.empty() || classes_.contains(name); }

  void add_kitti(const io::KittiDataset& dataset) {
    for (const std::string& frame : dataset.frames(flags_.split)) {
      const io::KittiPaths paths = dataset.paths(flags_.split, frame);
      const io::KittiCalibration calibration = io::read_kitti_calibration(paths.calibration);
      for (const io::KittiObject& object : io::read_kitti_labels(paths.label)) {
        if (!io::has_box(object) || !wanted(object.type)) continue;
        boxes.push_back(io::to_box(object, calibration));
      }
    }
  }

  void add_table(const io::BoxTable& table, const std::filesystem::path& file) {
    if (!classes_.empty() && table.classes.empty()) {
      throw UsageError(file.string() + ": has no column 'class' that --class could choose from");
    }
    for (std::size_t i = 0; i < table.boxes.size(); ++i) {
      if (table.classes.empty() || wanted(table.classes[i])) boxes.push_back(table.boxes[i]);
    }
  }

  const FitBinsFlags& flags_;
  std::set<std::string> classes_;
};

void print(const FitBinsResult& result, std::size_t boxes, const FitBinsFlags& flags) {
  if (flags.json) {
    std::cout << nlohmann::ordered_json{{"boxes", boxes},
                                        {"draws", flags.draws},
                                        {"mean_iou", result.mean_iou},
                                        {"overflow", result.overflow},
                                        {"codec", result.codec}}
                     .dump(2)
              << '\n';
    return;
  }
  std::cout << "# " << boxes << " boxes, " << flags.draws << " simulated references each: mean IoU "
            << std::fixed << std::setprecision(4) << result.mean_iou << " after quantisation, "
            << std::setprecision(3) << 100 * result.overflow << " % of components out of range\n"
            << result.codec;
}

void run(const FitBinsFlags& flags) {
  Collector collector(flags);
  for (const std::filesystem::path& input : flags.inputs) collector.add(input);
  if (collector.boxes.empty()) throw UsageError("fit-bins: the inputs hold no boxes of that kind");
  FitBinsRequest request{collector.boxes, {"kind=" + flags.kind}, flags.draws, flags.seed};
  request.codec.insert(request.codec.end(), flags.codec.begin(), flags.codec.end());
  const FitBinsResult result = torch_module().fit_bins(request);
  if (!result.reached) {
    std::ostringstream text;
    text << "fit-bins: the best ranges give a mean IoU of " << result.mean_iou << " with "
         << 100 * result.overflow << " % out of range, expected at least 0.99 and under 0.1 %; "
         << "ask for more bins, for example --set bins=1024";
    throw NumericalError(text.str());
  }
  print(result, request.boxes.size(), flags);
}

}  // namespace

void add_fit_bins(CLI::App& config) {
  const auto flags = std::make_shared<FitBinsFlags>();
  CLI::App* command = config.add_subcommand(
      "fit-bins",
      "Ranges of a codec's bins for the boxes of a data set: mean IoU of at least 0.99 "
      "after quantisation, under 0.1 % of components out of range");
  command->add_option("input", flags->inputs, "Folders in KITTI's layout, CSV box tables")
      ->required()
      ->check(CLI::ExistingPath)
      ->type_name("PATH");
  command->add_option("--split", flags->split, "Split of a KITTI folder")->capture_default_str();
  command->add_option("--class", flags->classes, "Only boxes of these classes")->delimiter(',');
  command->add_option("--kind", flags->kind, "Codec")
      ->check(CLI::IsMember({"residual", "scaled", "quartile"}))
      ->capture_default_str();
  command->add_option("--set", flags->codec, "Changes to the codec, for example bins=256")
      ->type_name("KEY=VALUE");
  command->add_option("--draws", flags->draws, "Simulated references of each box")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("--seed", flags->seed, "Seed of the references")->capture_default_str();
  add_json_flag(*command, flags->json);
  add_examples(*command, {{"arbox config fit-bins /data/kitti --split train --class Car",
                           "Ranges of PV-RCNN residuals, as YAML"},
                          {"arbox config fit-bins boxes.csv --kind quartile --set bins=256",
                           "Ranges for crops of boxes of any rotation"}});
  command->callback([flags] { run(*flags); });
}

}  // namespace arbox::cli
