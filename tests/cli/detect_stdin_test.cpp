#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/program.h"

namespace arbox::testing {
namespace {

using ::testing::HasSubstr;
using Lines = std::vector<nlohmann::json>;

const std::string kStreet = ARBOX_EXAMPLES "/data/street.bin";

std::string word(std::uint32_t value) {
  std::string bytes(4, '\0');
  for (int i = 0; i < 4; ++i) bytes[i] = static_cast<char>(value >> (8 * i));
  return bytes;
}

std::string frame(const std::string& points, std::uint32_t channels) {
  return word(static_cast<std::uint32_t>(points.size())) + word(channels) + points;
}

std::string floats(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

Lines lines_of(const std::string& text) {
  Lines lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

RunResult answer(const std::string& frames, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"detect", "--stdin", "--detector", "cluster_fit"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_arbox(arguments, {.input = frames});
}

TEST(DetectStdin, AnswersEachFrameAsTheFileWouldBe) {
  const std::string points = slurp(kStreet);
  const RunResult result = answer(frame(points, 4) + frame("", 4) + frame(points, 4),
                                  {"--quantile", "0.3", "--score", "0.5"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const Lines lines = lines_of(result.output);
  ASSERT_EQ(lines.size(), 3u);
  const auto file = nlohmann::json::parse(run_arbox({"detect", kStreet, "--detector", "cluster_fit",
                                                     "--quantile", "0.3", "--score", "0.5"})
                                              .output);
  EXPECT_EQ(lines[0]["source"], "frame 0");
  EXPECT_EQ(lines[0]["detections"], file["detections"]);
  EXPECT_FALSE(file["detections"].empty());
  EXPECT_EQ(lines[1]["source"], "frame 1");
  EXPECT_TRUE(lines[1]["detections"].empty());
  EXPECT_EQ(lines[2]["detections"], file["detections"]);
}

TEST(DetectStdin, TakesAnyChannelsAndPointsThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const RunResult result =
      answer(frame(floats({nan, nan, nan, 1, 2, 3}), 3) +
             frame(floats({1, 2, 3, 0.5F, 0, 0, 7, 9}), 8) + frame(floats({1, 2, 3, 250, 7}), 5));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(lines_of(result.output).size(), 3u);
  const std::string points = slurp(kStreet);
  EXPECT_EQ(answer(frame(points, 4), {"--channels", "x,y,z,_"}).exit_code, 0);
}

TEST(DetectStdin, NothingIsNoError) {
  const RunResult result = answer("");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "");
}

TEST(DetectStdin, RefusesABadFrameAndAnswersTheNext) {
  const std::string good = frame(floats({1, 2, 3}), 3);
  struct Case {
    std::string frame, reason;
  };
  const Case cases[] = {{frame(floats({1, 2}), 2), "3 to 64 channels, got 2"},
                        {frame("", 0), "3 to 64 channels, got 0"},
                        {frame(floats({1, 2, 3}), 4000000000U), "3 to 64 channels, got 4000000000"},
                        {frame(floats({1, 2, 3, 4}), 3), "whole points of 3 float32, got 16 bytes"},
                        {frame("12345678901", 3), "whole points of 3 float32, got 11 bytes"}};
  for (const Case& bad : cases) {
    const RunResult result = answer(good + bad.frame + good);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.errors, HasSubstr("1 of 3 frames refused"));
    const Lines lines = lines_of(result.output);
    ASSERT_EQ(lines.size(), 3u) << bad.reason;
    EXPECT_EQ(lines[1]["source"], "frame 1");
    EXPECT_THAT(lines[1]["error"].get<std::string>(), HasSubstr(bad.reason));
    EXPECT_TRUE(lines[2].contains("detections"));
  }
  const RunResult columns =
      answer(good + frame(floats({1, 2, 3, 4}), 4), {"--channels", "x,y,z,i"});
  EXPECT_THAT(columns.output, HasSubstr("expected the 4 channels of --channels, got 3"));
  EXPECT_EQ(columns.exit_code, 1);
}

TEST(DetectStdin, EndsAtAStreamThatIsCut) {
  const std::string good = frame(floats({1, 2, 3}), 3);
  struct Case {
    std::string rest, reason;
  };
  const Case cases[] = {
      {good.substr(0, 1), "header of 8 bytes, got 1"},
      {good.substr(0, 7), "header of 8 bytes, got 7"},
      {good.substr(0, 8), "expected 12 bytes of points, got 0"},
      {good.substr(0, good.size() - 1), "expected 12 bytes of points, got 11"},
      {word(1u << 30) + word(4) + good, "expected 1073741824 bytes of points, got 20"},
      {word((1u << 30) + 1) + word(4) + good, "at most 1073741824 bytes"},
      {"\xff\xff\xff\xff\xff\xff\xff\xff" + good, "at most 1073741824 bytes"}};
  for (const Case& cut : cases) {
    const RunResult result = answer(good + cut.rest);
    EXPECT_EQ(result.exit_code, 1) << cut.reason;
    const Lines lines = lines_of(result.output);
    ASSERT_EQ(lines.size(), 2u) << cut.reason;
    EXPECT_TRUE(lines[0].contains("detections"));
    EXPECT_THAT(lines[1]["error"].get<std::string>(), HasSubstr(cut.reason));
    EXPECT_THAT(result.errors, HasSubstr("1 of 2 frames refused"));
  }
}

TEST(DetectStdin, RefusesFlagsThatMakeNoSense) {
  expect_one_line_error(run_arbox({"detect", "--stdin", kStreet}), 2, {"--stdin", "street.bin"});
  expect_one_line_error(run_arbox({"detect", "--stdin", "--format", "csv"}), 2, {"--stdin"});
  expect_one_line_error(run_arbox({"detect", "--stdin", "--view", "a.png"}), 2, {"--stdin"});
  expect_one_line_error(run_arbox({"detect", "--stdin", "--detector", "none"}), 2, {"none"});
}

}  // namespace
}  // namespace arbox::testing
