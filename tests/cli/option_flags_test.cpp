#include "arbox/cli/option_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "base/options_fixture.h"

namespace {

using arbox::bind_options;
using arbox::cli::add_option_flags;
using arbox::testing::AllOptions;
using arbox::testing::Overlap;
using ::testing::HasSubstr;

AllOptions parse(std::vector<std::string> words) {
  AllOptions options;
  CLI::App app;
  add_option_flags(app, bind_options(options));
  std::reverse(words.begin(), words.end());
  app.parse(words);
  return options;
}

TEST(OptionFlags, SetEveryKindOfField) {
  const AllOptions options = parse({"--voxel-size", "0.1", "--offset", "-7", "--flip", "--name",
                                    "two words", "--quantiles", "0.1", "0.2", "--extent", "4,5,6",
                                    "--nms-overlap", "iog", "--nms-limit", "5"});
  EXPECT_EQ(options.voxel_size, 0.1);
  EXPECT_EQ(options.offset, -7);
  EXPECT_TRUE(options.flip);
  EXPECT_EQ(options.name, "two words");
  EXPECT_EQ(options.quantiles, (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(options.extent, (std::array<double, 3>{4, 5, 6}));
  EXPECT_EQ(options.nms.overlap, Overlap::kIog);
  EXPECT_EQ(options.nms.limit, 5);
}

TEST(OptionFlags, WithoutFlagsKeepDefaults) {
  const AllOptions options = parse({});
  EXPECT_EQ(options.voxel_size, 0.05);
  EXPECT_EQ(options.quantiles, (std::vector<double>{0.1, 0.9}));
  EXPECT_FALSE(options.flip);
}

TEST(OptionFlags, SwitchesTurnOffAndOptionalsEmpty) {
  AllOptions options;
  options.flip = true;
  options.nms.limit = 3;
  CLI::App app;
  add_option_flags(app, bind_options(options));
  app.parse("--no-flip --nms-limit null");
  EXPECT_FALSE(options.flip);
  EXPECT_EQ(options.nms.limit, std::nullopt);
}

TEST(OptionFlags, ViolationsAreUsageErrorsWithTheExpectedRange) {
  try {
    parse({"--nms-threshold", "1.5"});
    FAIL() << "accepted";
  } catch (const CLI::ParseError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--nms-threshold"));
    EXPECT_THAT(error.what(), HasSubstr("expected number from 0 to 1, got '1.5'"));
  }
  EXPECT_THROW(parse({"--extent", "1,2"}), CLI::ParseError);
  EXPECT_THROW(parse({"--mode", "slow"}), CLI::ParseError);
  EXPECT_THROW(parse({"--voxl-size", "1"}), CLI::ParseError);
}

TEST(OptionFlags, HelpShowsMeaningRangeUnitAndDefault) {
  AllOptions options;
  CLI::App app;
  add_option_flags(app, bind_options(options), {"seed"});
  const std::string help = app.help();
  EXPECT_THAT(help, HasSubstr("--voxel-size VALUE=0.05"));
  EXPECT_THAT(help, HasSubstr("Edge of a voxel (number from 0.001 to 10, m)"));
  EXPECT_THAT(help, HasSubstr("--flip,--no-flip"));
  EXPECT_EQ(help.find("--seed"), std::string::npos);
}

}  // namespace
