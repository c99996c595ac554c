#include <CLI/CLI.hpp>

#include "arbox/cli/commands.h"

namespace arbox::cli {

void add_info(CLI::App& app) {
  CLI::App* info = app.add_subcommand("info", "Tell what is in files and data sets");
  info->require_subcommand(1);
  add_info_kitti(*info);
}

}  // namespace arbox::cli
