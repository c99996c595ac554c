#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::RunResult;
using arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

constexpr std::string_view kUnitCubes = "0,0,0,1,1,1,0\n0.5,0,0,1,1,1,0\n";

RunResult overlap(const std::string& first, const std::string& second,
                  const std::vector<std::string>& more = {"--measure", "iou"}) {
  std::vector<std::string> arguments = {"overlap", "--first", first, "--second", second};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_arbox(arguments);
}

class OverlapCommand : public ::testing::Test {
 protected:
  std::string file(std::string_view name, std::string_view text) const {
    return folder_.write(name, text).string();
  }

 private:
  TemporaryDirectory folder_;
};

TEST_F(OverlapCommand, PrintsOneRowABoxOfTheFirstFileWithSeventeenDigits) {
  const auto cubes = file("cubes.csv", kUnitCubes);
  const auto three =
      file("three.csv", "x,y,z,l,w,h,yaw\n0,0,0,1,1,1,0\n9,9,9,1,1,1,0\n0,0,0,2,2,2,0\n");
  const RunResult result = overlap(cubes, three);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "1,0,0.125\n0.33333333333333331,0,0.125\n");
  EXPECT_EQ(overlap(three, cubes, {"--measure", "iog"}).output, "1,0.5\n0,0\n1,1\n");
  EXPECT_EQ(overlap(cubes, three, {"--measure", "intersection"}).output, "1,0,1\n0.5,0,1\n");
}

TEST_F(OverlapCommand, ReadsOneFileFromStandardInput) {
  const auto cubes = file("cubes.csv", kUnitCubes);
  const std::string expected = overlap(cubes, cubes).output;
  for (const auto& [first, second] :
       {std::pair<std::string, std::string>{"-", cubes}, {cubes, "-"}}) {
    const RunResult result =
        run_arbox({"overlap", "--first", first, "--second", second, "--measure", "iou"},
                  {.input = std::string(kUnitCubes)});
    EXPECT_EQ(result.output, expected) << result.errors;
  }
  expect_one_line_error(overlap("-", "-"), 2, {"standard input"});
}

TEST_F(OverlapCommand, ReadsQuaternionsAndNormalisesThemWithinAThousandth) {
  // A quarter turn about x: y and z sizes change places.
  const auto turned =
      file("turned.csv", "x y z l w h qw qx qy qz\n0 0 0 1 2 4 0.7075 0.7075 0 0\n");
  const auto plain = file("plain.csv", "0,0,0,1,4,2,0\n");
  const RunResult result = overlap(turned, plain);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_NEAR(std::stod(result.output), 1.0, 1e-12);
  const auto bad = file("bad.csv", "0,0,0,1,1,1,1,0,0,0\n0,0,0,1,2,4,0.7,0.6,0,0\n");
  expect_one_line_error(overlap(bad, plain), 1, {"bad.csv", "2"});
}

TEST_F(OverlapCommand, MeasuresInTheSpaceAskedFor) {
  const auto low = file("low.csv", "0,0,0,2,2,1,0\n");
  const auto high = file("high.csv", "1,0,50,2,2,3,0\n");
  EXPECT_EQ(overlap(low, high, {"--measure", "intersection"}).output, "0\n");
  EXPECT_EQ(overlap(low, high, {"--measure", "intersection", "--space", "bev"}).output, "2\n");
  const auto turned = file("turned.csv", "0,0,0,2,2,1,0.7\n");
  EXPECT_EQ(overlap(low, turned, {"--measure", "iou", "--space", "axis-aligned"}).output, "1\n");
  EXPECT_LT(std::stod(overlap(low, turned).output), 0.9);
  const auto tilted = file("tilted.csv", "0,0,0,1,1,1,1,0,0,0\n0,0,0,1,1,1,0.8,0.6,0,0\n");
  expect_one_line_error(overlap(low, tilted, {"--measure", "iou", "--space", "bev"}), 1,
                        {"row 1", "+z"});
}

TEST_F(OverlapCommand, PrintsJson) {
  const auto cubes = file("cubes.csv", kUnitCubes);
  const auto shown =
      nlohmann::json::parse(overlap(cubes, cubes, {"--measure", "intersection", "--json"}).output);
  EXPECT_EQ(shown.at("measure"), "intersection");
  EXPECT_EQ(shown.at("space"), "3d");
  EXPECT_EQ(shown.at("overlaps"), nlohmann::json::parse("[[1, 0.5], [0.5, 1]]"));
  const auto none = file("none.csv", "");
  EXPECT_EQ(nlohmann::json::parse(overlap(none, none, {"--measure", "iou", "--json"}).output)
                .at("overlaps"),
            nlohmann::json::array());
}

TEST_F(OverlapCommand, EmptyTablesGiveEmptyRows) {
  const auto cubes = file("cubes.csv", kUnitCubes);
  const auto none = file("none.csv", "x,y,z,l,w,h,yaw\n");
  const RunResult no_rows = overlap(none, cubes);
  EXPECT_EQ(no_rows.exit_code, 0) << no_rows.errors;
  EXPECT_EQ(no_rows.output, "");
  EXPECT_EQ(overlap(cubes, none).output, "\n\n");
}

TEST_F(OverlapCommand, GivesTheSameBytesAtAnyThreadCount) {
  std::ostringstream boxes;
  for (int i = 0; i < 300; ++i) {
    boxes << std::sin(i) * 5 << ' ' << std::cos(3 * i) * 5 << ' ' << 0.001 * i << " 4 2 1.5 "
          << 0.1 * i << '\n';
  }
  const auto table = file("table.csv", boxes.str());
  const RunResult one = overlap(table, table, {"--measure", "iou", "--threads", "1"});
  EXPECT_EQ(one.exit_code, 0) << one.errors;
  EXPECT_EQ(std::count(one.output.begin(), one.output.end(), '\n'), 300);
  EXPECT_EQ(one.output, overlap(table, table, {"--measure", "iou", "--threads", "4"}).output);
}

TEST_F(OverlapCommand, RefusesBadInputInOneLine) {
  const auto cubes = file("cubes.csv", kUnitCubes);
  const auto refused = [&](std::string_view row, const std::vector<std::string>& parts) {
    const auto bad = file("bad.csv", std::string(kUnitCubes) + std::string(row) + "\n");
    expect_one_line_error(overlap(bad, cubes), 1, parts);
    expect_one_line_error(overlap(cubes, bad), 1, parts);
  };
  refused("0,0,0,1,0,1,0", {"bad.csv", "3"});
  refused("0,0,0,1,-2,1,0", {"bad.csv", "3"});
  refused("0,0,0,1,nan,1,0", {"bad.csv", "3"});
  refused("0,0,inf,1,1,1,0", {"bad.csv", "3"});
  refused("0,0,0,1,1,1", {"bad.csv", "3"});
  refused("0,0,0,1,1,one,0", {"bad.csv", "3", "one"});
  refused("0,0,0,1,1e-70,1,0", {"row 2", "1e-40"});
  expect_one_line_error(overlap("/no/such/file.csv", cubes), 1, {"/no/such/file.csv"});
}

TEST_F(OverlapCommand, WrongUsageGivesExitCodeTwo) {
  const auto cubes = file("cubes.csv", kUnitCubes);
  expect_one_line_error(overlap(cubes, cubes, {}), 2, {"--measure"});
  expect_one_line_error(overlap(cubes, cubes, {"--measure", "giou"}), 2, {"giou"});
  expect_one_line_error(overlap(cubes, cubes, {"--measure", "iou", "--space", "4d"}), 2, {"4d"});
  expect_one_line_error(run_arbox({"overlap", "--measure", "iou", "--first", cubes}), 2,
                        {"--second"});
  const RunResult help = run_arbox({"overlap", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.output, HasSubstr("Examples:"));
}

}  // namespace
