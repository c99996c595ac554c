#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

/// \file
/// Helpers of tests that run the real `arbox` program, write files or read real data.

namespace arbox::testing {

/// How a program is run.
struct RunOptions {
  /// The whole of standard input.
  std::string input = {};
  /// Set on top of this process's environment; an empty value unsets the variable.
  std::map<std::string, std::string> environment = {};
  std::filesystem::path working_directory = {};
  double timeout_seconds = 60;
  /// Close the program's standard output after this many bytes, as `head -c` does.
  std::size_t output_limit = SIZE_MAX;
};

struct RunResult {
  /// The exit code; 128 + the signal's number if a signal ended the program.
  int exit_code = -1;
  std::string output;
  std::string errors;
  bool timed_out = false;
};

/// Runs a program without a shell and waits for its end; a program that outlives its time is killed
/// with SIGKILL and told as timed_out.
RunResult run(const std::filesystem::path& program, const std::vector<std::string>& arguments,
              const RunOptions& options = {});

/// Runs `arbox`, found through the environment variable ARBOX_PROGRAM that ctest sets.
RunResult run_arbox(const std::vector<std::string>& arguments, const RunOptions& options = {});

/// Expects exit code `exit_code`, nothing on standard output and one line on standard error that
/// begins with "arbox: " and contains each of `parts`.
void expect_one_line_error(const RunResult& result, int exit_code,
                           const std::vector<std::string>& parts);

/// A new empty folder, removed with its content at the end of the scope.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  /// Writes a file into the folder, making the folders between, and gives its path.
  std::filesystem::path write(std::string_view name, std::string_view content) const;

 private:
  std::filesystem::path path_;
};

/// The whole content of a file; fails the test and gives "" if it cannot be read.
std::string slurp(const std::filesystem::path& path);

/// Where real data would be: ARBOX_DATA / name. Empty if ARBOX_DATA is unset or holds no such name.
std::filesystem::path find_data(std::string_view name);

}  // namespace arbox::testing

/// Declares `variable` as the path of real data, or skips the test with a message that says what
/// to set. Use: ARBOX_REQUIRE_DATA(scan, "kitti/training/velodyne/000008.bin");
#define ARBOX_REQUIRE_DATA(variable, name)                                  \
  const std::filesystem::path variable = ::arbox::testing::find_data(name); \
  if (variable.empty())                                                     \
  GTEST_SKIP() << "needs " << (name) << ": set ARBOX_DATA to the folder that holds it"
