#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/program.h"

namespace {

using namespace arbox::testing;
using ::testing::HasSubstr;

constexpr std::string_view kBoxes =
    "x,y,z,l,w,h,yaw,score,class\n"
    "0,0,0,4,2,2,0,0.5,Car\n"
    "0.1,0,0,4,2,2,0,0.9,Car\n"
    "0.2,0,0,4,2,2,0,0.7,Van\n"
    "20,0,0,4,2,2,1,0.1,Car\n";

class NmsCommand : public ::testing::Test {
 protected:
  RunResult nms(std::string_view text, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"nms", folder_.write("boxes.csv", text).string()});
    return run_arbox(more);
  }
  std::vector<int> kept(std::string_view text, std::vector<std::string> more = {}) const {
    more.push_back("--json");
    const RunResult result = nms(text, more);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return nlohmann::json::parse(result.output).at("kept");
  }

 private:
  TemporaryDirectory folder_;
};

TEST_F(NmsCommand, KeepsTheBestRows) {
  EXPECT_EQ(kept(kBoxes), (std::vector{1, 3}));
  EXPECT_EQ(kept(kBoxes, {"--class-aware"}), (std::vector{1, 2, 3}));
  EXPECT_EQ(kept(kBoxes, {"--threshold", "0.96"}), (std::vector{1, 2, 0, 3}));
  EXPECT_EQ(kept(kBoxes, {"--space", "3d", "--post-limit", "1"}), (std::vector{1}));
  EXPECT_EQ(kept(kBoxes, {"--soft", "gaussian", "--minimum-score", "0.2"}), (std::vector{1}));
}

TEST_F(NmsCommand, PrintsRowsThatItReadsAgain) {
  const RunResult result = nms(kBoxes);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("score"));
  EXPECT_THAT(result.output, HasSubstr("Car"));
  EXPECT_EQ(kept(result.output), (std::vector{0, 1}));
}

TEST_F(NmsCommand, WithoutAHeaderTheScoreFollowsTheBox) {
  EXPECT_EQ(kept("0,0,0,4,2,2,0,0.5\n0,0,0,4,2,2,0,0.6\n"), (std::vector{1}));
  EXPECT_EQ(kept("0,0,0,4,2,2,1,0,0,0,0.5\n0,0,0,4,2,2,1,0,0,0,0.6\n"), (std::vector{1}));
}

TEST_F(NmsCommand, EmptyFilesAreFine) { EXPECT_TRUE(kept("").empty()); }

TEST_F(NmsCommand, BadInputIsOneLine) {
  expect_one_line_error(run_arbox({"nms", "/nowhere/boxes.csv"}), 1, {"/nowhere/boxes.csv"});
  expect_one_line_error(nms("0,0,0,4,2,2,0\n"), 1, {"boxes.csv", "score"});
  expect_one_line_error(nms("0,0,0,4,2,2,0,0.5\n", {"--class-aware"}), 1, {"class"});
  expect_one_line_error(nms("0,0,0,4,-2,2,0,0.5\n"), 1, {"boxes.csv"});
  expect_one_line_error(nms(kBoxes, {"--threshold", "1.5"}), 2, {"threshold"});
  expect_one_line_error(nms(kBoxes, {"--space", "4d"}), 2, {"space"});
}

}  // namespace
