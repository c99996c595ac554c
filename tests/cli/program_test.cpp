#include "support/program.h"

#include <gtest/gtest.h>

namespace {

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

TEST(Program, WrongUsageExitsWithTwo) {
  EXPECT_EQ(run_arbox({}).exit_code, 2);
  EXPECT_EQ(run_arbox({"no-such-command"}).exit_code, 2);
  EXPECT_EQ(run_arbox({"--threads", "0"}).exit_code, 2);
}

}  // namespace
