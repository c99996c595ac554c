#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "arbox/base/options.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/progress.h"
#include "arbox/simulation/street_dataset.h"

namespace arbox::cli {
namespace {

struct SimulateStreetFlags {
  std::int64_t scenes = 0;
  std::uint64_t seed = 0;
  std::filesystem::path output;
  bool json = false;
  simulation::StreetDatasetOptions options;
};

void simulate_street(const SimulateStreetFlags& flags) {
  Progress progress("simulate", flags.scenes);
  const auto report = simulation::write_street_dataset(
      flags.options, flags.seed, flags.scenes, flags.output, 0, [&] { progress.advance(); });
  if (flags.json) {
    std::cout << nlohmann::ordered_json{{"output", flags.output.string()},
                                        {"written", report.written},
                                        {"found", report.found}}
                     .dump(2)
              << '\n';
    return;
  }
  std::cout << report.written << " scenes written, " << report.found << " found in "
            << flags.output.string() << '\n';
}

void add_street(CLI::App& simulate) {
  CLI::App* command = simulate.add_subcommand("street",
                                              "LiDAR scans of streets with exact labels, pictures "
                                              "too, in the KITTI object benchmark's layout");
  const auto flags = std::make_shared<SimulateStreetFlags>();
  command->add_option("--scenes", flags->scenes, "Number of scans")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000}))
      ->required();
  command->add_option("--seed", flags->seed, "Equal seeds give equal bytes (default: 0)");
  command->add_option("--output", flags->output, "Folder to write to, made if need be")
      ->type_name("DIR")
      ->required();
  command
      ->add_option_function<std::string>(
          "--config",
          [flags](const std::string& file) {
            flags->options = read_options<simulation::StreetDatasetOptions>(file, flags->options);
          },
          "Options as YAML (arbox config show street_dataset)")
      ->type_name("YAML")
      ->trigger_on_parse();
  add_option_flags(*command, bind_options(flags->options));
  add_json_flag(*command, flags->json);
  add_examples(*command, {{"arbox simulate street --scenes 1000 --seed 1 --output streets",
                           "A thousand scans; a run that was stopped goes on where it stood"},
                          {"arbox simulate street --scenes 10 --output streets --images",
                           "With pictures of the left colour camera"},
                          {"arbox simulate street --scenes 10 --output streets --lidar spinning32",
                           "Another scanner"}});
  command->callback([flags] { simulate_street(*flags); });
}

}  // namespace

void add_simulate(CLI::App& app) {
  CLI::App* command = app.add_subcommand("simulate", "Simulated scans with exact labels");
  add_examples(*command, {{"arbox simulate street --scenes 10 --output streets",
                           "Ten scans with labels, as a KITTI folder"}});
  command->require_subcommand(1);
  add_street(*command);
}

}  // namespace arbox::cli
