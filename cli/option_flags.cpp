#include "arbox/cli/option_flags.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace arbox::cli {
namespace {

void assign(const BoundOption& option, const OptionInput& input) {
  if (const auto violation = assign_option(option, input)) {
    throw CLI::ValidationError(flag_name(option.key), *violation);
  }
}

std::string help_text(const BoundOption& option) {
  const std::string unit = option.field.unit.empty() ? "" : ", " + std::string(option.field.unit);
  return std::string(option.field.help) + " (" + option_type(option) + unit + ")";
}

CLI::Option* add_value(CLI::App& command, const BoundOption& option) {
  const std::string flag = flag_name(option.key);
  if (is_list(option)) {
    return command
        .add_option_function<std::vector<std::string>>(
            flag, [option](const std::vector<std::string>& values) { assign(option, values); },
            help_text(option))
        ->delimiter(',')
        ->type_name("VALUE...");
  }
  return command
      .add_option_function<std::string>(
          flag,
          [option](const std::string& value) {
            const bool emptied = value == "null" && !assign_option(option, OptionInput());
            if (!emptied) assign(option, value);
          },
          help_text(option))
      ->type_name("VALUE");
}

void add_switch(CLI::App& command, const BoundOption& option) {
  const std::string flag = flag_name(option.key);
  command.add_flag_function(
      flag + ",!--no-" + flag.substr(2),
      [option](std::int64_t count) { assign(option, count > 0 ? "true" : "false"); },
      help_text(option) + ", default " + option_text(option));
}

}  // namespace

std::string flag_name(const std::string& key) {
  std::string flag = "--" + key;
  std::replace_if(
      flag.begin(), flag.end(), [](char letter) { return letter == '.' || letter == '_'; }, '-');
  return flag;
}

void add_option_flags(CLI::App& command, const BoundOptions& options,
                      const std::vector<std::string>& without) {
  for (const BoundOption& option : options.fields) {
    if (std::find(without.begin(), without.end(), option.key) != without.end()) continue;
    if (is_switch(option)) {
      add_switch(command, option);
    } else {
      add_value(command, option)->default_str(option_text(option));
    }
  }
}

}  // namespace arbox::cli
