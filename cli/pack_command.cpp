#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/torch_module.h"
#include "arbox/io/file.h"
#include "arbox/io/model_search.h"

namespace arbox::cli {
namespace {

struct PackFlags {
  std::string model, card;
  PackRequest request;
};

void pack(PackFlags& flags) {
  flags.request.model = std::filesystem::is_directory(flags.model)
                            ? flags.model
                            : io::find_model(flags.model).string();
  if (!flags.request.average.empty()) {
    flags.request.average = io::find_model(flags.request.average).string();
  }
  if (!flags.card.empty()) flags.request.card = io::read_file(flags.card);
  torch_module().pack(flags.request);
  std::printf("model         %s\nbytes         %llu\n", flags.request.output.c_str(),
              static_cast<unsigned long long>(std::filesystem::file_size(flags.request.output)));
}

}  // namespace

void add_pack(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "pack", "Make a trained model ready to be given away: smaller, with a card, other defaults");
  const auto flags = std::make_shared<PackFlags>();
  command
      ->add_option(
          "model", flags->model,
          "A .arbox file, the name of an installed model, or the folder of a training run, "
          "also of one that has not ended: its last checkpoint")
      ->required()
      ->type_name("MODEL|DIR");
  command
      ->add_option("-o,--output", flags->request.output, "The model to write; may be the same file")
      ->required()
      ->type_name("FILE");
  command->add_flag("--half", flags->request.half,
                    "Write weights as float16, half the size; norms, biases and statistics stay");
  CLI::Option* average =
      command
          ->add_option("--average", flags->request.average,
                       "Mix with the weights of another model of the same network; the result "
                       "is not calibrated")
          ->type_name("FILE|NAME");
  command->add_option("--share", flags->request.share, "The other model's share of the mean")
      ->needs(average)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--average-except", flags->request.average_except,
                   "Parts that keep their own weights, for example box_heads")
      ->needs(average)
      ->type_name("PART");
  command
      ->add_option("--card", flags->card,
                   "Markdown: what the model was trained on, how good it is, what it is not for")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command
      ->add_option("--set", flags->request.overrides,
                   "Changes to the model's options, for example post.score=0.2")
      ->type_name("KEY=VALUE");
  add_examples(*command,
               {{"arbox pack runs/street/model.arbox --half --card card.md --output "
                 "street.arbox",
                 "Half the size, with a card; calibrate what comes of it"},
                {"arbox pack runs/street --output now.arbox", "What a run has learnt up to now"},
                {"arbox info street.arbox", "Card, configuration and size"}});
  command->callback([flags] { pack(*flags); });
}

}  // namespace arbox::cli
