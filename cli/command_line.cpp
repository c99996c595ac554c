#include "arbox/cli/command_line.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <csignal>
#include <exception>
#include <iostream>
#include <new>

#include "arbox/base/blas.h"
#include "arbox/base/names.h"
#include "arbox/base/parallel.h"

namespace arbox::cli {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kWrongUsage = 2 };

void set_up_logging() {
  auto logger = spdlog::stderr_color_mt("arbox");
  logger->set_pattern("%n: %^%l%$: %v");
  logger->set_level(spdlog::level::warn);
  spdlog::set_default_logger(std::move(logger));
}

int fail(std::string_view text, ExitCode code) {
  std::cout.flush();
  spdlog::error("{}", fold_lines(text));
  return code;
}

int finish(int code) {
  if (std::cout.flush()) return code;
  return fail("cannot write to standard output", kFailed);
}

// The command that was being parsed, in full: "arbox plugins check".
std::string command_name(const CLI::App& app) {
  const auto parsed = app.get_subcommands();
  return parsed.empty() ? app.get_name() : app.get_name() + " " + command_name(*parsed.front());
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::string usage_text(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* last = &app;
  while (!last->get_subcommands().empty()) last = last->get_subcommands().front();
  // Words that a command does not know fall through to the program.
  const auto left = app.remaining();
  std::string text = error.what();
  const bool wants_command = !last->get_subcommands({}).empty();
  if (wants_command && !left.empty() && !left.front().starts_with("-")) {
    text = unknown_name_text("command", left.front(), command_names(*last));
  }
  return text + " (see '" + command_name(app) + " --help')";
}

void be_verbose() {
  spdlog::set_level(spdlog::level::debug);
  if (const std::string kernels = blas_kernels(); !kernels.empty()) {
    spdlog::debug("OpenBLAS works with its kernels for {}", kernels);
  }
}

void declare_common(CLI::App& app) {
  app.set_version_flag("--version", ARBOX_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option_function<int>(
         "--threads", [](int count) { set_default_threads(count); },
         "Threads to use (default: OMP_NUM_THREADS, else every core)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024).description(""));
  app.add_flag_callback("--verbose", be_verbose, "Tell on standard error what is being done");
}

}  // namespace

void add_examples(CLI::App& command, std::initializer_list<Example> examples) {
  std::string footer = "Examples:\n";
  for (const Example& example : examples) {
    footer += "  " + std::string(example.command) + "\n      " + std::string(example.effect) + "\n";
  }
  const bool program = command.get_parent() == nullptr;
  if (!program) footer += "\nEvery command takes --threads, --verbose and --plugin: arbox --help\n";
  command.footer(footer);
}

void add_json_flag(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print JSON instead of a table for people");
}

std::string fold_lines(std::string_view text) {
  static constexpr std::string_view kSpace = " \t\r\n\v\f";
  std::string folded;
  while (!text.empty()) {
    const std::size_t words = std::min(text.find_first_of(kSpace), text.size());
    folded += text.substr(0, words);
    text.remove_prefix(words);
    const std::size_t space = std::min(text.find_first_not_of(kSpace), text.size());
    const std::string_view gap = text.substr(0, space);
    text.remove_prefix(space);
    if (gap.find_first_of("\r\n") == std::string_view::npos) {
      folded += gap;
    } else if (!folded.empty() && !text.empty()) {
      folded += ' ';
    }
  }
  return folded;
}

int run_program(int argc, char** argv, const std::function<void(CLI::App&)>& add_commands) {
  // A reader that has seen enough (`arbox ... | head`) ends the program without a word.
  std::signal(SIGPIPE, SIG_DFL);
  mend_blas_kernels();
  std::ios::sync_with_stdio(false);
  set_up_logging();
  CLI::App app("Arbox finds objects in point clouds and says how sure it is of each box.", "arbox");
  try {
    declare_common(app);
    add_commands(app);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return finish(app.exit(error));
    return fail(usage_text(app, error), kWrongUsage);
  } catch (const UsageError& error) {
    return fail(std::string(error.what()) + " (see '" + command_name(app) + " --help')",
                kWrongUsage);
  } catch (const std::bad_alloc&) {
    return fail("not enough memory", kFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kFailed);
  }
  return finish(kDone);
}

}  // namespace arbox::cli
