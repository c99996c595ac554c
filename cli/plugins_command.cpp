#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "arbox/base/plugin_loader.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/program_registry.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

struct PluginFlags {
  std::filesystem::path file;
  bool json = false;
};

Json to_json(const PluginDescription& plugin) {
  return {{"kind", plugin.kind},
          {"name", plugin.name},
          {"version", plugin.version},
          {"licence", plugin.licence},
          {"file", plugin.file.string()}};
}

Json inspect(const std::filesystem::path& file) {
  try {
    return to_json(inspect_plugin(file, full_program_registry()));
  } catch (const PluginError& error) {
    return {{"file", file.string()}, {"error", error.what()}};
  }
}

void print_table(const Json& built_in, const Json& plugins) {
  for (const Json& entry : built_in) {
    std::cout << entry["kind"].get<std::string>() << ' ' << entry["name"].get<std::string>() << "  "
              << entry["help"].get<std::string>() << " (built in)\n";
  }
  for (const Json& plugin : plugins) {
    if (plugin.contains("error")) {
      std::cout << "refused: " << fold_lines(plugin["error"].get<std::string>()) << '\n';
    } else {
      std::cout << plugin["kind"].get<std::string>() << ' ' << plugin["name"].get<std::string>()
                << "  version " << plugin["version"].get<std::string>() << ", "
                << plugin["licence"].get<std::string>() << ", " << plugin["file"].get<std::string>()
                << '\n';
    }
  }
}

void list(const PluginFlags& flags) {
  Json built_in = Json::array();
  Json plugins = Json::array();
  for (const RegistryEntry& entry : full_program_registry().entries()) {
    if (entry.origin == "built in") {
      built_in.push_back({{"kind", entry.kind}, {"name", entry.name}, {"help", entry.help}});
    } else {
      plugins.push_back(inspect(entry.origin));
    }
  }
  for (const std::filesystem::path& file : find_plugins()) plugins.push_back(inspect(file));
  if (flags.json) {
    std::cout << Json{{"built_in", built_in}, {"plugins", plugins}}.dump(2) << '\n';
    return;
  }
  print_table(built_in, plugins);
  std::cout << "looked in:";
  for (const std::filesystem::path& folder : plugin_folders()) std::cout << ' ' << folder.string();
  std::cout << '\n';
}

/// Heads need LibTorch; other kinds are loaded without it.
Registry& registry_for(const std::filesystem::path& file) {
  const bool head = file.filename().string().starts_with("libarbox_head_");
  return head ? full_program_registry() : program_registry();
}

void check(const PluginFlags& flags) {
  const PluginDescription plugin = load_plugin(flags.file, full_program_registry());
  if (flags.json) {
    std::cout << to_json(plugin).dump(2) << '\n';
  } else {
    std::cout << plugin.file.string() << ": fits this build; " << plugin.kind << ' ' << plugin.name
              << ", version " << plugin.version << ", " << plugin.licence << '\n';
  }
}

}  // namespace

void add_plugins(CLI::App& app) {
  app.add_option_function<std::vector<std::string>>(
         "--plugin",
         [](const std::vector<std::string>& files) {
           for (const std::string& file : files) load_plugin(file, registry_for(file));
         },
         "Load this plugin first; may be given several times")
      ->type_name("FILE")
      ->allow_extra_args(false);
  CLI::App* plugins = app.add_subcommand("plugins", "List and check plugins");
  plugins->require_subcommand(1);
  add_examples(*plugins, {{"arbox plugins list", "What is built in and what is found"}});

  const auto flags = std::make_shared<PluginFlags>();
  CLI::App* list_command = plugins->add_subcommand(
      "list",
      "Built-ins, then the plugins in the folders of ARBOX_PLUGIN_PATH and the installation");
  add_json_flag(*list_command, flags->json);
  add_examples(*list_command,
               {{"ARBOX_PLUGIN_PATH=/opt/arbox arbox plugins list --json",
                 "Plugins of a folder of your own too; refused ones with the reason"}});
  list_command->callback([flags] { list(*flags); });

  CLI::App* check_command = plugins->add_subcommand(
      "check", "Load one plugin and tell what it is, or why it does not fit");
  check_command->add_option("file", flags->file, "The plugin's library")->required();
  add_json_flag(*check_command, flags->json);
  add_examples(*check_command, {{"arbox plugins check ./libarbox_detector_mine.so",
                                 "Exit code 1 and each difference if it does not fit"}});
  check_command->callback([flags] { check(*flags); });
}

}  // namespace arbox::cli
