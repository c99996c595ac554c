#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "arbox/base/error.h"
#include "base/options_fixture.h"
#include "support/program.h"

namespace {

using arbox::ConfigError;
using arbox::IoError;
using arbox::options_yaml;
using arbox::parse_options;
using arbox::read_options;
using arbox::testing::AllOptions;
using arbox::testing::Overlap;
using arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

std::string refusal(const std::string& yaml) {
  try {
    parse_options<AllOptions>(yaml, "a.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted: " << yaml;
  return "";
}

TEST(ParseOptions, KeepsDefaultsOfKeysThatAreNotNamed) {
  const auto options = parse_options<AllOptions>("layers: 7\nnms:\n  overlap: iog\n", "a.yaml");
  EXPECT_EQ(options.layers, 7);
  EXPECT_EQ(options.nms.overlap, Overlap::kIog);
  EXPECT_EQ(options.nms.threshold, 0.5);
  EXPECT_EQ(options.voxel_size, 0.05);
}

TEST(ParseOptions, StartsFromTheGivenDefaults) {
  AllOptions defaults;
  defaults.layers = 9;
  EXPECT_EQ(parse_options("flip: true", "a.yaml", defaults).layers, 9);
}

TEST(ParseOptions, EmptyDocumentIsAllDefaults) {
  for (const char* yaml : {"", "\n\n", "# nothing\n", "---\n"}) {
    EXPECT_EQ(parse_options<AllOptions>(yaml, "a.yaml").layers, 3) << yaml;
  }
}

TEST(ParseOptions, NamesFileLineAndNearestKey) {
  EXPECT_THAT(refusal("layers: 2\n\nvoxl_size: 1\n"),
              HasSubstr("a.yaml:3: unknown key 'voxl_size', nearest is 'voxel_size'; known: "));
  EXPECT_THAT(refusal("nms:\n  treshold: 1\n"),
              HasSubstr("a.yaml:2: unknown key 'nms.treshold', nearest is 'nms.threshold'"));
  EXPECT_THAT(refusal("threshold: 0.5\n"),
              HasSubstr("a.yaml:1: unknown key 'threshold', nearest is 'nms.threshold'"));
}

TEST(ParseOptions, ListsAllViolationsAtOnce) {
  EXPECT_EQ(refusal("layers: 0\nmode: slow\nflip: 3\nnms:\n  threshold: 2\n"),
            "a.yaml:1: layers: expected integer of at least 1, got '0'; "
            "a.yaml:2: mode: expected one of fast, exact, got 'slow'; "
            "a.yaml:3: flip: expected true or false, got '3'; "
            "a.yaml:5: nms.threshold: expected number from 0 to 1, got '2'");
}

TEST(ParseOptions, RefusesWhatYamlWouldLetPass) {
  EXPECT_THAT(refusal("layers: 1\nlayers: 2\n"), HasSubstr("a.yaml:2: key 'layers' stands twice"));
  EXPECT_THAT(refusal("layers:\n"), HasSubstr("expected integer of at least 1, got nothing"));
  EXPECT_THAT(refusal("layers: [1]\n"), HasSubstr("got [1]"));
  EXPECT_THAT(refusal("layers: {a: 1}\n"), HasSubstr("got nested keys"));
  EXPECT_THAT(refusal("extent: 1\n"), HasSubstr("expected list of 3 numbers"));
  EXPECT_THAT(refusal("nms: 1\n"), HasSubstr("a.yaml:1: nms: expected keys with values"));
  EXPECT_THAT(refusal("nms:\n"), HasSubstr("nms: expected keys with values"));
  EXPECT_THAT(refusal("[1, 2]\n"), HasSubstr("a.yaml:1: expected keys with values"));
  EXPECT_THAT(refusal("just words\n"), HasSubstr("expected keys with values"));
  EXPECT_THAT(refusal("? [a]\n: 1\n"), HasSubstr("expected a word as key"));
  EXPECT_THAT(refusal("layers: 1\n---\nlayers: 2\n"), HasSubstr("expected one YAML document"));
}

TEST(ParseOptions, NamesTheLineOfWhatIsNotYaml) {
  EXPECT_THAT(refusal("layers: 1\nextent: [1, 2\n"), HasSubstr("a.yaml:"));
  EXPECT_THAT(refusal("layers: 1\nextent: [1, 2\n"), HasSubstr("not YAML"));
  EXPECT_THAT(refusal("a: *nowhere\n"), HasSubstr("a.yaml:1: not YAML"));
  EXPECT_THAT(refusal(std::string("\x00\x01\xff", 3)), HasSubstr("a.yaml:"));
  EXPECT_THAT(refusal(std::string(100'000, '[')), HasSubstr("not YAML"));
}

TEST(OptionsYaml, ReadsBackToTheSameValues) {
  AllOptions options;
  options.voxel_size = 0.1 + 0.2;
  options.offset = std::numeric_limits<std::int64_t>::min();
  options.name = "two\r\nlines\tand # 'quotes' \\";
  options.classes = {"", "true", "3", "~", "- a", "null", "\xc3\xa9"};
  options.mask = {true, false};
  options.note = "null";
  options.nms.limit = 4;
  options.nms.overlap = Overlap::kIog;
  const std::string yaml = options_yaml(options);
  const auto read = parse_options<AllOptions>(yaml, "dump");
  EXPECT_EQ(options_yaml(read), yaml);
  EXPECT_EQ(read.voxel_size, options.voxel_size);
  EXPECT_EQ(read.name, options.name);
  EXPECT_EQ(read.classes, options.classes);
  EXPECT_EQ(read.note, options.note);
  EXPECT_EQ(read.mask, options.mask);
  EXPECT_EQ(read.seed, options.seed);
  EXPECT_EQ(read.reach, options.reach);
}

TEST(OptionsYaml, CarriesHelpUnitAndRange) {
  const std::string yaml = options_yaml(AllOptions());
  EXPECT_THAT(yaml,
              HasSubstr("# Edge of a voxel (number from 0.001 to 10, in m)\nvoxel_size: 0.05\n"));
  EXPECT_THAT(yaml, HasSubstr("# How overlapping boxes are merged\nnms:\n  # Overlap from which"));
  EXPECT_THAT(yaml, HasSubstr("  overlap: iou\n"));
}

TEST(ReadOptions, NamesTheFileThatItCannotRead) {
  const TemporaryDirectory folder;
  EXPECT_EQ(read_options<AllOptions>(folder.write("a.yaml", "layers: 5")).layers, 5);
  const auto error = [](const std::filesystem::path& file) -> std::string {
    try {
      read_options<AllOptions>(file);
    } catch (const IoError& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_THAT(error(folder / "none.yaml"), HasSubstr("none.yaml: cannot read: No such file"));
  EXPECT_THAT(error(folder.path()), HasSubstr("got a folder"));
}

}  // namespace
