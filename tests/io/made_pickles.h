#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/program.h"

namespace arbox::testing {

/// A file that make_pickles.py makes, which runs once.
inline std::filesystem::path made_pickle(const std::string& name) {
  static const TemporaryDirectory folder;
  static const RunResult made =
      run("/usr/bin/python3", {ARBOX_MAKE_PICKLES, folder.path().string()});
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  return folder / name;
}

}  // namespace arbox::testing
