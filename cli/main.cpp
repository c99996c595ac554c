#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "arbox/base/parallel.h"
#include "arbox/cli/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Arbox finds objects in point clouds and says how sure it is of each box.", "arbox");
  app.set_version_flag("--version", ARBOX_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option_function<int>(
         "--threads", [](int count) { arbox::set_default_threads(count); },
         "Threads to use (default: OMP_NUM_THREADS, else every core)")
      ->check(CLI::Range(1, 1024));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::cerr << "arbox: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
