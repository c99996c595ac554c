#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "arbox/base/names.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/torch_module.h"

namespace arbox::cli {
namespace {

struct ImportFlags {
  ImportRequest request;
  std::string layout = "automatic";
  bool json = false;
};

void print(const ImportFlags& flags, const ImportResult& result) {
  if (flags.json) {
    std::cout << nlohmann::ordered_json{{"checkpoint", flags.request.checkpoint},
                                        {"model", flags.request.output},
                                        {"head", result.head},
                                        {"classes", result.classes},
                                        {"layout", result.layout},
                                        {"entries", result.entries},
                                        {"parameters", result.parameters},
                                        {"unused", result.unused}}
                     .dump(2)
              << '\n';
    return;
  }
  const auto row = [](const char* name, const std::string& value) {
    std::printf("%-12s%s\n", name, value.c_str());
  };
  row("model", flags.request.output);
  row("head", result.head);
  row("classes", join(result.classes, ", "));
  row("parameters", std::to_string(result.parameters) + " in " + std::to_string(result.entries) +
                        " entries, sparse convolutions as in " + result.layout);
}

void run(ImportFlags& flags) {
  flags.request.options = {"layout=" + flags.layout};
  const ImportResult result = torch_module().import_openpcdet(flags.request);
  if (!result.unused.empty()) {
    spdlog::warn("entries of the checkpoint that the network has no place for: {}",
                 join(result.unused, ", "));
  }
  print(flags, result);
}

}  // namespace

void add_import(CLI::App& app) {
  CLI::App* import = app.add_subcommand("import", "Models from checkpoints of other programs");
  import->require_subcommand(1);
  CLI::App* command = import->add_subcommand(
      "openpcdet",
      "A PV-RCNN checkpoint (.pth) of OpenPCDet, or of the autoregressive network by Liu et al., "
      "as a model. Nothing in the file is run");
  const auto flags = std::make_shared<ImportFlags>();
  ImportRequest& request = flags->request;
  command->add_option("checkpoint", request.checkpoint, "The checkpoint")
      ->required()
      ->type_name("FILE");
  command->add_option("-o,--output", request.output, "The model to write (.arbox)")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--config", request.configuration,
                   "Options of the network that was trained; KITTI's PV-RCNN if not given")
      ->type_name("YAML");
  command
      ->add_option("--set", request.overrides,
                   "Changes to its options, for example "
                   "classes=[Vehicle, Pedestrian, Cyclist]")
      ->type_name("KEY=VALUE");
  command
      ->add_option("--layout", flags->layout,
                   "Layout of the weights of sparse convolutions, if their shapes do not tell")
      ->check(CLI::IsMember({"automatic", "spconv1", "spconv2", "spconv2_native"}))
      ->capture_default_str();
  command->add_flag("--half", request.half, "Write weights as float16: half the size");
  add_json_flag(*command, flags->json);
  add_examples(*import, {{"arbox import openpcdet pv_rcnn_8369.pth --output pv_rcnn.arbox",
                          "OpenPCDet's KITTI model"}});
  add_examples(*command, {{"arbox import openpcdet pv_rcnn_8369.pth --output pv_rcnn.arbox",
                           "OpenPCDet's KITTI model"},
                          {"arbox info pv_rcnn.arbox", "What came of it"}});
  command->callback([flags] { run(*flags); });
}

}  // namespace arbox::cli
