#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/program.h"

namespace {

using namespace arbox::testing;
using nlohmann::json;

// The paper's stack of height 1.2: heights 1.2 / i, bottoms at 0.
constexpr std::string_view kStack =
    "0,0,0.6,1,1,1.2,0\n0,0,0.3,1,1,0.6,0\n0,0,0.2,1,1,0.4,0\n0,0,0.15,1,1,0.3,0\n";

class QuantileBoxCommand : public ::testing::Test {
 protected:
  RunResult run(std::string_view text, std::vector<std::string> more) const {
    more.insert(more.begin(),
                {"quantile-box", "--samples", folder_.write("samples.csv", text).string()});
    return run_arbox(more);
  }
  json objects(std::string_view text, const std::vector<std::string>& more) const {
    const RunResult result = run(text, more);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return json::parse(result.output).at("objects");
  }
  TemporaryDirectory folder_;
};

TEST_F(QuantileBoxCommand, GivesTheHeightsOfThePaper) {
  const json result = objects(kStack, {"--quantile", "0.1", "0.3", "0.6", "0.9", "1"});
  ASSERT_EQ(result.size(), 1u);
  EXPECT_EQ(result[0]["object"], 0);
  const std::vector<double> heights = {1.2, 0.6, 0.4, 0.3, 0.3};
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const json& entry = result[0]["quantile_boxes"][i];
    EXPECT_NEAR(entry["box"]["size"][2], heights[i], 1e-9);
    EXPECT_NEAR(entry["box"]["center"][2], heights[i] / 2, 1e-9);
    EXPECT_EQ(entry["fallback"], i == 4);
    EXPECT_TRUE(entry["box"].contains("yaw"));
  }
  EXPECT_EQ(result[0]["quantile_boxes"][0]["q"], 0.1);
  EXPECT_NEAR(result[0]["uncertainty"], 1 - 0.3 / 1.2, 1e-9);
  const json other = objects(kStack, {"--quantile", "0.1", "--uncertainty", "0.3", "0.6"});
  EXPECT_NEAR(other[0]["uncertainty"], 1 - 0.4 / 0.6, 1e-9);
}

TEST_F(QuantileBoxCommand, TheFirstColumnGroupsAndASeedRepeats) {
  const std::string text =
      "object,x,y,z,l,w,h,qw,qx,qy,qz\n7,0,0,0,1,1,1,1,0,0,0\n-3,5,0,0,2,1,1,0.8,0.6,0,0\n"
      "7,0.1,0,0,1,1,1,0.8,0,0,0.6\n";
  const json result = objects(text, {"--quantile", "0.6", "--seed", "5"});
  ASSERT_EQ(result.size(), 2u);
  EXPECT_EQ(result[0]["object"], -3);
  EXPECT_EQ(result[1]["object"], 7);
  EXPECT_EQ(result, objects(text, {"--quantile", "0.6", "--seed", "5", "--threads", "2"}));
  EXPECT_NE(result, objects(text, {"--quantile", "0.6", "--seed", "6"}));
}

TEST_F(QuantileBoxCommand, WritesRowsOrAFile) {
  const RunResult rows = run(kStack, {"--quantile", "0.1", "0.9", "--csv", "-"});
  EXPECT_EQ(rows.exit_code, 0) << rows.errors;
  EXPECT_EQ(std::count(rows.output.begin(), rows.output.end(), '\n'), 3);
  EXPECT_TRUE(rows.output.starts_with("object,q,fallback,uncertainty,x,y,z,l,w,h,qw,qx,qy,qz\n"));
  const auto file = folder_ / "boxes.json";
  const RunResult result = run(kStack, {"--quantile", "0.1", "--json", file.string()});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "");
  EXPECT_EQ(json::parse(slurp(file))["objects"], objects(kStack, {"--quantile", "0.1"}));
  EXPECT_TRUE(objects("", {"--quantile", "0.1"}).empty());
  EXPECT_EQ(objects(kStack, {"--quantile", "0.1", "--json", "-"}),
            objects(kStack, {"--quantile", "0.1"}));
  const RunResult piped = run_arbox({"quantile-box", "--samples", "-", "--quantile", "0.1"},
                                    {.input = std::string(kStack)});
  EXPECT_EQ(piped.output, run(kStack, {"--quantile", "0.1"}).output) << piped.errors;
}

TEST_F(QuantileBoxCommand, BadInputIsOneLine) {
  expect_one_line_error(run(kStack, {"--quantile", "1.5"}), 2, {"--quantile"});
  expect_one_line_error(run(kStack, {}), 2, {"--quantile"});
  expect_one_line_error(run("0,0,0,1,1\n", {"--quantile", "0.5"}), 1, {"samples.csv"});
  expect_one_line_error(run("0,0,0,1,1,0,0\n", {"--quantile", "0.5"}), 1, {"samples.csv"});
  expect_one_line_error(run(kStack, {"--quantile", "0.5", "--placement", "grid"}), 2,
                        {"placement"});
  expect_one_line_error(
      run_arbox({"quantile-box", "--samples", "/nowhere/a.csv", "--quantile", "0.5"}), 1,
      {"/nowhere/a.csv"});
}

}  // namespace
