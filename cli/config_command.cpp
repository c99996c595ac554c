#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/options_catalog.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

struct ConfigFlags {
  std::string name;
  std::string file;
  std::vector<std::string> overrides;
  bool json = false;
  bool table = false;
};

using SharedFlags = std::shared_ptr<ConfigFlags>;

Json describe(const BoundOptions& options) {
  Json fields = Json::array();
  for (const BoundOption& option : options.fields) {
    fields.push_back({{"key", option.key},
                      {"values", option_type(option)},
                      {"value", option_text(option)},
                      {"unit", option.field.unit},
                      {"help", option.field.help}});
  }
  return fields;
}

void list(const ConfigFlags& flags) {
  const std::vector<CatalogName> catalog = options_names();
  if (flags.json) {
    Json entries = Json::array();
    for (const CatalogName& entry : catalog) {
      entries.push_back({{"name", entry.name}, {"help", entry.help}});
    }
    std::cout << entries.dump(2) << '\n';
    return;
  }
  std::size_t width = 0;
  for (const CatalogName& entry : catalog) width = std::max(width, entry.name.size());
  for (const CatalogName& entry : catalog) {
    std::cout << std::left << std::setw(static_cast<int>(width) + 2) << entry.name << entry.help
              << '\n';
  }
}

void print(const ConfigFlags& flags, const BoundOptions& options) {
  if (flags.json) {
    std::cout << Json{{"name", flags.name}, {"fields", describe(options)}}.dump(2) << '\n';
  } else {
    std::cout << (flags.table ? options_table(options) : options_yaml(options));
  }
}

void show(const ConfigFlags& flags) {
  const OptionsInstance instance = find_options(flags.name).make();
  if (!flags.file.empty()) {
    assign_yaml(instance.fields, read_options_file(flags.file), flags.file);
  }
  assign_overrides(instance.fields, flags.overrides);
  print(flags, instance.fields);
}

void check(const ConfigFlags& flags) {
  const OptionsInstance instance = find_options(flags.name).make();
  assign_yaml(instance.fields, read_options_file(flags.file), flags.file);
  if (flags.json) {
    print(flags, instance.fields);
  } else {
    std::cout << flags.file << ": fits " << flags.name << '\n';
  }
}

void add_list(CLI::App& config, const SharedFlags& flags) {
  CLI::App* command = config.add_subcommand("list", "Names of all options structs");
  add_json_flag(*command, flags->json);
  add_examples(*command, {{"arbox config list", "What can be configured"}});
  command->callback([flags] { list(*flags); });
}

void add_show(CLI::App& config, const SharedFlags& flags) {
  CLI::App* command = config.add_subcommand(
      "show", "One struct as YAML with its help: defaults, or changed by a file and by key=value");
  command->add_option("name", flags->name, "A name that `arbox config list` gives")->required();
  command->add_option("--file", flags->file, "YAML file to apply")->type_name("FILE");
  command->add_option("--set", flags->overrides, "Changes, for example nms.threshold=0.3")
      ->type_name("KEY=VALUE");
  command->add_flag("--table", flags->table, "Print a Markdown table");
  add_json_flag(*command, flags->json);
  add_examples(*command, {{"arbox config show detector/cluster_fit > mine.yaml",
                           "A commented file to start from"},
                          {"arbox config show detector/cluster_fit --set min_points=12 --json",
                           "Values after a change"}});
  command->callback([flags] { show(*flags); });
}

void add_check(CLI::App& config, const SharedFlags& flags) {
  CLI::App* command = config.add_subcommand("check", "Validate a YAML file");
  command->add_option("name", flags->name, "A name that `arbox config list` gives")->required();
  command->add_option("file", flags->file, "YAML file")->required();
  add_json_flag(*command, flags->json);
  add_examples(
      *command,
      {{"arbox config check detector/cluster_fit mine.yaml",
        "Tells every unknown key and bad value with its line; exit code 1 if there is one"}});
  command->callback([flags] { check(*flags); });
}

}  // namespace

void add_config(CLI::App& app) {
  CLI::App* config = app.add_subcommand("config", "Show and check configurations");
  config->require_subcommand(1);
  const auto flags = std::make_shared<ConfigFlags>();
  add_list(*config, flags);
  add_show(*config, flags);
  add_check(*config, flags);
  add_fit_bins(*config);
  add_examples(*config,
               {{"arbox config list", "What can be configured"},
                {"arbox config show detector/cluster_fit", "Its keys, defaults and help"}});
}

}  // namespace arbox::cli
