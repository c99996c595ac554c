// arbox info FILE and arbox convert IN OUT.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::TemporaryDirectory;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr const char* kText = "x,y,z,intensity\n1,2,3,40\n-4,5,6,80\nnan,0,0,0\n";

TEST(Info, TellsFormatPointsChannelsAndBounds) {
  const TemporaryDirectory folder;
  const auto path = folder.write("a.csv", kText);
  const auto result = run_arbox({"info", path, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const json info = json::parse(result.output);
  EXPECT_EQ(info["format"], "text");
  EXPECT_EQ(info["encoding"], "comma-separated");
  EXPECT_EQ(info["points"], 3);
  EXPECT_EQ(info["non_finite"], 1);
  EXPECT_EQ(info["bounds"], (json{{"min", {-4, 2, 3}}, {"max", {1, 5, 6}}}));
  EXPECT_EQ(info["channels"]["intensity"], (json{{"min", 40}, {"max", 80}, {"mean", 60}}));
  const auto table = run_arbox({"info", path});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_THAT(table.output, HasSubstr("points      3\n"));
  EXPECT_THAT(table.output,
              HasSubstr("intensity                 40            80            60\n"));
}

TEST(Info, ReadsStandardInput) {
  const auto result = run_arbox({"info", "-", "--json"}, {.input = kText});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(json::parse(result.output)["points"], 3);
  const auto raw = run_arbox({"info", "-", "--format", "bin", "--channels", "3", "--json"},
                             {.input = std::string(24, '\0')});
  EXPECT_EQ(json::parse(raw.output)["points"], 2);
}

TEST(Info, RefusesInOneLine) {
  const TemporaryDirectory folder;
  expect_one_line_error(run_arbox({"info", folder / "none.pcd"}), 1, {"none.pcd", "no such file"});
  expect_one_line_error(run_arbox({"info", folder.path()}), 1, {"looks like no dataset"});
  expect_one_line_error(run_arbox({"info", folder.write("a.pcd", "")}), 1, {"a.pcd", "empty file"});
  expect_one_line_error(run_arbox({"info", folder.write("b.bin", std::string(60, '\0'))}), 1,
                        {"b.bin", "3 or 5 float32"});
  expect_one_line_error(run_arbox({"info", folder.write("c.pcd",
                                                        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"
                                                        "WIDTH 1000000000000\nDATA binary\n")}),
                        1, {"c.pcd", "expected 12000000000000 bytes", "got 0"});
  EXPECT_EQ(run_arbox({"info"}).exit_code, 2);
}

TEST(Convert, EveryFormatHoldsTheSamePoints) {
  const TemporaryDirectory folder;
  const auto path = folder.write("a.csv", kText);
  const std::pair<const char*, std::vector<std::string>> outputs[] = {
      {"b.pcd", {"--encoding", "ascii"}},
      {"c.pcd", {"--encoding", "binary_compressed"}},
      {"d.ply", {}},
      {"e.bin", {}},
      {"f.npy", {}},
      {"g.npz", {}},
      {"h.txt", {}}};
  for (const auto& [name, more] : outputs) {
    std::vector<std::string> arguments{"convert", path, folder / name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run_arbox(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_EQ(result.output, "");
    EXPECT_THAT(result.errors, HasSubstr("dropped 1 of 3 points"));
    const auto back = run_arbox({"convert", folder / name, "-", "--to", "text"});
    EXPECT_EQ(back.output, "x,y,z,intensity\n1,2,3,40\n-4,5,6,80\n") << name << back.errors;
  }
  const auto kept = run_arbox({"convert", path, folder / "k.ply", "--keep-non-finite", "--json"});
  EXPECT_EQ(json::parse(kept.output)["points"], 3);
  EXPECT_EQ(json::parse(kept.output)["non_finite"], 1);
  const auto scaled = run_arbox(
      {"convert", path, "-", "--to", "text", "--scale-intensity", "--write-channels", "intensity"});
  EXPECT_THAT(scaled.output, HasSubstr("-4,5,6,0.3137255\n"));
}

TEST(Convert, WorksInAPipe) {
  const auto pcd = run_arbox({"convert", "-", "-", "--to", "pcd"}, {.input = "1 2 3\n4 5 6\n"});
  ASSERT_EQ(pcd.exit_code, 0) << pcd.errors;
  const auto text = run_arbox({"convert", "-", "-", "--to", "text"}, {.input = pcd.output});
  EXPECT_EQ(text.output, "x,y,z\n1,2,3\n4,5,6\n");
}

TEST(Convert, RefusesInOneLineAndLeavesNoFile) {
  const TemporaryDirectory folder;
  const auto path = folder.write("a.csv", "x,y,z\n1,2,oops\n");
  expect_one_line_error(run_arbox({"convert", path, folder / "b.pcd"}), 1, {"a.csv:2", "'oops'"});
  EXPECT_FALSE(std::filesystem::exists(folder / "b.pcd"));
  expect_one_line_error(run_arbox({"convert", path, folder / "b.jpg"}), 2, {"b.jpg", "--to"});
  EXPECT_EQ(run_arbox({"convert", path}).exit_code, 2);
  EXPECT_EQ(run_arbox({"convert", path, "-", "--to", "las"}).exit_code, 2);
}

}  // namespace
