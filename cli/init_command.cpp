#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/io/arbox_dataset.h"

namespace arbox::cli {
namespace {

struct InitFlags {
  std::string root, frame = "lidar";
  std::vector<std::string> classes;
};

void init(const InitFlags& flags) {
  const io::InitReport report = io::init_dataset(flags.root, {.frame = io::frame_named(flags.frame),
                                                              .classes = flags.classes,
                                                              .class_map = {},
                                                              .columns = {}});
  for (const std::string& made : report.made) std::cout << "made " << made << '\n';
  if (report.made.empty()) std::cout << "nothing was missing\n";
  std::cout << report.scans << " scans, " << report.labels << " label files\n";
  for (const std::string& note : report.notes) std::cout << "next: " << note << '\n';
  std::cout << "next: arbox info " << flags.root << '\n';
}

}  // namespace

void add_init(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "init", "Prepare a folder for your own scans and labels; what is there stays as it is");
  const auto flags = std::make_shared<InitFlags>();
  command->add_option("dataset", flags->root, "Folder of the dataset; made if it is not there")
      ->type_name("DIR")
      ->required();
  command->add_option("--frame", flags->frame, "Frame of the clouds and labels")
      ->check(CLI::IsMember({"lidar", "room", "camera"}))
      ->capture_default_str();
  command
      ->add_option("--classes", flags->classes,
                   "Classes, separated by commas (default: those of the labels)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("CLASS");
  add_examples(*command,
               {{"arbox init my_data --classes Car,Pedestrian", "Folders and dataset.json"},
                {"arbox info my_data", "Check what was put into it"}});
  command->callback([flags] { init(*flags); });
}

}  // namespace arbox::cli
