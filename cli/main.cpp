#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"

int main(int argc, char** argv) {
  return arbox::cli::run_program(argc, argv, [](CLI::App& app) { arbox::cli::add_config(app); });
}
