#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>

#include "arbox/base/error.h"

/// \file
/// What every command of the program shares.
///
/// Messages for people go to standard error through spdlog (`spdlog::warn("...")`; info and debug
/// show with --verbose), results to standard output. A flag `--json` turns a table for people into
/// JSON on standard output. Errors are exceptions; run_program turns them into one line.

namespace arbox::cli {

/// The command line asks for what makes no sense, found only after it was parsed: exit code 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

struct Example {
  std::string_view command;
  std::string_view effect;
};

/// Shows examples below the help of a command.
void add_examples(CLI::App& command, std::initializer_list<Example> examples);

/// Adds `--json`: results as JSON on standard output instead of a table for people.
void add_json_flag(CLI::App& command, bool& json);

/// The text as one line: every run of white space with a line break in it becomes one space.
std::string fold_lines(std::string_view text);

/// Runs the program: `add_commands` declares the commands. Gives the exit code: 0 done, 1 failed,
/// 2 wrong usage; a failure is one line on standard error, "arbox: error: ...".
int run_program(int argc, char** argv, const std::function<void(CLI::App&)>& add_commands);

}  // namespace arbox::cli
