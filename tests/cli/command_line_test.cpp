#include "arbox/cli/command_line.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "arbox/base/cpu.h"
#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run;
using arbox::testing::run_arbox;
using arbox::testing::RunOptions;
using arbox::testing::TemporaryDirectory;

TEST(Run, GivesExitCodeOutputAndErrors) {
  const auto result = run("/bin/sh", {"-c", "cat; echo \"$WORD\" >&2; exit 3"},
                          {.input = "hello", .environment = {{"WORD", "there"}}});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.output, "hello");
  EXPECT_EQ(result.errors, "there\n");
  EXPECT_FALSE(result.timed_out);
}

TEST(Run, PassesMuchMoreThanAPipeHolds) {
  const std::string text(5'000'000, 'x');
  EXPECT_EQ(run("/bin/cat", {}, {.input = text}).output, text);
}

TEST(Run, KillsWhatOutlivesItsTime) {
  const auto result = run("/bin/sleep", {"60"}, {.timeout_seconds = 0.2});
  EXPECT_TRUE(result.timed_out);
  EXPECT_EQ(result.exit_code, 128 + 9);
}

TEST(TemporaryDirectory, IsRemovedWithItsContent) {
  std::filesystem::path path;
  {
    const TemporaryDirectory folder;
    path = folder.path();
    EXPECT_EQ(arbox::testing::slurp(folder.write("a/b.txt", "text")), "text");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Program, TellsItsVersion) {
  const auto result = run_arbox({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(result.output.starts_with("0.")) << result.output;
  EXPECT_EQ(result.errors, "");
}

#if defined(__x86_64__)
TEST(Program, SaysWithWhichKernelsOpenBlasWorks) {
  const auto told = [](const std::string& choice) {
    const auto result = run_arbox({"config", "list", "--verbose"},
                                  {.environment = {{"OPENBLAS_CORETYPE", choice}}});
    EXPECT_EQ(result.exit_code, 0);
    return result.errors;
  };
  EXPECT_EQ(told("Nehalem"), "arbox: debug: OpenBLAS works with its kernels for Nehalem\n");
  const std::string chosen = told("");
  EXPECT_TRUE(chosen.starts_with("arbox: debug: OpenBLAS works with its kernels for ")) << chosen;
  if (arbox::best_simd_level() != arbox::SimdLevel::kScalar) {
    EXPECT_EQ(chosen.find("Prescott"), std::string::npos) << chosen;
  }
}
#endif

TEST(Program, WrongUsageIsOneLineAndExitsWithTwo) {
  expect_one_line_error(run_arbox({}), 2, {"arbox --help"});
  expect_one_line_error(run_arbox({"--threads", "0", "config", "list"}), 2, {"--threads"});
  expect_one_line_error(run_arbox({"config", "list", "--bogus"}), 2,
                        {"--bogus", "arbox config list --help"});
}

TEST(Program, NamesTheNearestCommand) {
  expect_one_line_error(run_arbox({"confg"}), 2, {"unknown command 'confg', nearest is 'config'"});
  expect_one_line_error(run_arbox({"config", "lst"}), 2,
                        {"unknown command 'lst', nearest is 'list'", "arbox config --help"});
}

TEST(Program, HelpGoesToStandardOutput) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--help"}, {"config", "--help"}, {"config", "show", "--help"}}) {
    const auto result = run_arbox(words);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.output.find("Usage: arbox"), std::string::npos);
    EXPECT_EQ(result.errors, "");
  }
}

/// The commands below the ones given, as their help lists them.
std::vector<std::string> commands_below(std::vector<std::string> words) {
  words.push_back("--help");
  std::istringstream help(run_arbox(words).output);
  std::vector<std::string> names;
  std::string line;
  bool listed = false;
  while (std::getline(help, line)) {
    if (line.ends_with(":")) listed = line == "Subcommands:";
    if (!listed || !line.starts_with("  ") || line[2] == ' ') continue;
    names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

void expect_examples_below(const std::vector<std::string>& words, int& commands) {
  std::vector<std::string> asked = words;
  asked.push_back("--help");
  const std::string help = run_arbox(asked).output;
  const std::size_t examples = help.find("\nExamples:\n");
  ASSERT_NE(examples, std::string::npos) << ::testing::PrintToString(words);
  EXPECT_NE(help.find("arbox ", examples), std::string::npos) << help;
  for (const std::string& name : commands_below(words)) {
    std::vector<std::string> deeper = words;
    deeper.push_back(name);
    ++commands;
    expect_examples_below(deeper, commands);
  }
}

TEST(Program, EveryHelpHasExamples) {
  int commands = 0;
  expect_examples_below({}, commands);
  EXPECT_GE(commands, 17);
}

TEST(Program, FailsWhenStandardOutputIsFull) {
  const char* program = std::getenv("ARBOX_PROGRAM");
  ASSERT_NE(program, nullptr);
  const auto result = run("/bin/sh", {"-c", "\"$0\" --help > /dev/full", program});
  expect_one_line_error(result, 1, {"cannot write to standard output"});
}

TEST(Program, SaysNothingWhenItsReaderIsGone) {
  const char* program = std::getenv("ARBOX_PROGRAM");
  ASSERT_NE(program, nullptr);
  const auto result = run("/bin/sh", {"-c", "(sleep 0.1; \"$0\" --help) | true", program});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.errors, "");
}

TEST(FoldLines, MakesOneLineAndKeepsTheRest) {
  EXPECT_EQ(arbox::cli::fold_lines("a  b\n   c\r\n\n"), "a  b c");
  EXPECT_EQ(arbox::cli::fold_lines("\n\na"), "a");
  EXPECT_EQ(arbox::cli::fold_lines(""), "");
  EXPECT_EQ(arbox::cli::fold_lines("\n"), "");
}

}  // namespace
