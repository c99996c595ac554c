#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "arbox/base/options.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/torch_module.h"
#include "arbox/cli/training_progress.h"

namespace arbox::cli {
namespace {

struct TrainFlags {
  std::string config;
  std::vector<std::string> overrides;
  std::filesystem::path output;
  std::filesystem::path resumed;
};

/// The configuration that a run keeps in its folder (training/pv_rcnn_training.h).
constexpr const char* kKept = "config.yaml";

TrainRequest new_run(const TrainFlags& flags) {
  if (flags.config.empty()) throw UsageError("train: expected a CONFIG file, or --resume DIR");
  const std::filesystem::path config = flags.config;
  const std::filesystem::path folder =
      flags.output.empty() ? std::filesystem::path("runs") / config.stem() : flags.output;
  return {.folder = folder,
          .configuration = config,
          .overrides = flags.overrides,
          .resume = false,
          .observer = nullptr};
}

TrainRequest resumed_run(const TrainFlags& flags) {
  if (!flags.output.empty()) throw UsageError("train: --output cannot be changed by --resume");
  TrainRequest request{.folder = flags.resumed,
                       .configuration = flags.resumed / kKept,
                       .overrides = flags.overrides,
                       .resume = true,
                       .observer = nullptr};
  if (!flags.config.empty()) {
    if (flags.config.find('=') == std::string::npos) {
      throw UsageError("train: --resume takes the configuration of its folder, got also '" +
                       flags.config + "'");
    }
    request.overrides.insert(request.overrides.begin(), flags.config);
  }
  return request;
}

std::string ending_text(const TrainOutcome& outcome, const std::filesystem::path& folder) {
  const std::string steps = std::to_string(outcome.steps) + " steps";
  const std::string skipped =
      outcome.skipped > 0 ? ", " + std::to_string(outcome.skipped) + " of them skipped" : "";
  if (outcome.finished) {
    return "trained " + steps + skipped + ": " + (folder / "model.arbox").string();
  }
  return "ended after " + steps + skipped + "; go on with: arbox train --resume " + folder.string();
}

void train(const TrainFlags& flags) {
  TrainRequest request = flags.resumed.empty() ? new_run(flags) : resumed_run(flags);
  TrainOutcome outcome;
  {
    TrainingProgress progress;
    request.observer = &progress;
    outcome = torch_module().train(request);
  }
  if (outcome.leads) std::cout << ending_text(outcome, request.folder) << '\n';
}

}  // namespace

void add_train(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "train", "Train a detector; a run can be ended at any time (Ctrl-C, SIGTERM) and resumed");
  const auto flags = std::make_shared<TrainFlags>();
  command->add_option("config", flags->config, "Configuration (arbox config show train/pv_rcnn)")
      ->type_name("CONFIG");
  command->add_option("overrides", flags->overrides, "Changes, for example train.steps=1000")
      ->type_name("KEY=VALUE");
  command
      ->add_option("--output", flags->output,
                   "Folder of the run, made if need be (default: runs/NAME of the configuration)")
      ->type_name("DIR");
  command->add_option("--resume", flags->resumed, "Go on with the run in this folder")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  add_examples(*command, {{"arbox train configs/train_compact_street.yaml --output runs/street",
                           "Log, loss picture, checkpoints and at last model.arbox in runs/street"},
                          {"arbox train --resume runs/street train.threads=1",
                           "Goes on where the run was ended or killed"},
                          {"MASTER_ADDR=10.0.0.1 WORLD_SIZE=2 RANK=1 arbox train config.yaml",
                           "The second of two machines that train together"}});
  command->callback([flags] { train(*flags); });
}

}  // namespace arbox::cli
