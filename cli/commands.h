#pragma once

#include <CLI/App.hpp>

/// \file
/// The commands of the `arbox` program, one source file each. A command adds its subcommand with
/// flags and examples; its callback does the work, prints results on standard output and lets
/// exceptions out: main turns them into one line on standard error and an exit code (0 done,
/// 1 failed, 2 wrong usage).

namespace arbox::cli {}  // namespace arbox::cli
