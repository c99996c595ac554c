#include "arbox/io/file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <thread>

#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox::io {
namespace {

using arbox::testing::expect_refusal;
using arbox::testing::slurp;
using arbox::testing::TemporaryDirectory;

std::ptrdiff_t entries(const std::filesystem::path& folder) {
  return std::distance(std::filesystem::directory_iterator(folder), {});
}

TEST(WriteFile, ReplacesTheContentAndLeavesNothingBeside) {
  const TemporaryDirectory folder;
  write_file(folder / "a", "long content");
  write_file(folder / "a", "short");
  EXPECT_EQ(read_file(folder / "a"), "short");
  EXPECT_EQ(read_file(folder / "a", 2), "sh");
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(WriteFile, KeepsLinksAndWritesWhatTheyLeadTo) {
  const TemporaryDirectory folder;
  folder.write("there/real", "old");
  std::filesystem::create_symlink(folder / "there/real", folder / "link");
  write_file(folder / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(slurp(folder / "there/real"), "new");
  EXPECT_EQ(entries(folder.path()), 2);
}

TEST(WriteFile, WritesIntoPipesAndDevices) {
  const TemporaryDirectory folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::string came;
  std::thread reader([&] { came = read_file(pipe); });
  write_file(pipe, "through the pipe");
  reader.join();
  EXPECT_EQ(came, "through the pipe");
  write_file("/dev/null", "gone");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(WriteFile, TellsWhyItCannot) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "taken");
  expect_refusal([&] { write_file(folder / "nowhere/a", ""); },
                 {"nowhere/a", "there is no folder"});
  expect_refusal([&] { write_file(folder / "taken", ""); }, {"taken", "directory"});
  EXPECT_EQ(entries(folder.path()), 1);
  expect_refusal([&] { write_file("/dev/full", std::string(1 << 20, 'x')); },
                 {"/dev/full", "No space left"});
}

TEST(ReadFile, RefusesWhatIsNoFile) {
  const TemporaryDirectory folder;
  expect_refusal([&] { read_file(folder / "missing"); }, {"missing", "no such file"});
  expect_refusal([&] { read_file(folder.path()); }, {"directory"});
}

}  // namespace
}  // namespace arbox::io
