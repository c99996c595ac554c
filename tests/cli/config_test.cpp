#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::RunResult;
using arbox::testing::TemporaryDirectory;
using nlohmann::json;
using ::testing::HasSubstr;

// A detector that a plugin brings, so that these tests hang on no built-in's options.
RunResult config(std::vector<std::string> words) {
  words.insert(words.begin(), {"--plugin", ARBOX_DETECTOR_PLUGIN, "config"});
  return run_arbox(words);
}

TEST(ConfigShow, PrintsDefaultsWithHelp) {
  const auto result = config({"show", "detector/blind"});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "# How long it looks (integer from 0 to 60, in s)\npatience: 3\n");
}

TEST(ConfigShow, LooksForPluginsByTheirName) {
  const std::string folder = std::filesystem::path(ARBOX_DETECTOR_PLUGIN).parent_path();
  const auto result = run_arbox({"config", "show", "detector/blind"},
                                {.environment = {{"ARBOX_PLUGIN_PATH", folder}}});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, ::testing::HasSubstr("patience: 3"));
}

TEST(ConfigShow, AppliesFileThenChanges) {
  const TemporaryDirectory folder;
  const auto file = folder.write("a.yaml", "patience: 4\n");
  EXPECT_THAT(config({"show", "detector/blind", "--file", file}).output,
              HasSubstr("patience: 4\n"));
  EXPECT_THAT(config({"show", "detector/blind", "--file", file, "--set", "patience=5"}).output,
              HasSubstr("patience: 5\n"));
  expect_one_line_error(config({"show", "detector/blind", "--set", "patience=99"}), 1,
                        {"patience: expected integer from 0 to 60 (s), got '99'"});
}

TEST(ConfigShow, PrintsTablesAndJson) {
  EXPECT_THAT(config({"show", "detector/blind", "--table"}).output,
              HasSubstr("| `patience` | integer from 0 to 60 | `3` | s | How long it looks |"));
  const json shown = json::parse(config({"show", "detector/blind", "--json"}).output);
  EXPECT_EQ(shown.at("name"), "detector/blind");
  EXPECT_EQ(shown.at("fields").at(0).at("key"), "patience");
  EXPECT_EQ(shown.at("fields").at(0).at("value"), "3");
}

TEST(ConfigShow, WhatItPrintsIsAccepted) {
  const json entries = json::parse(config({"list", "--json"}).output);
  EXPECT_FALSE(entries.empty());
  const TemporaryDirectory folder;
  for (const json& entry : entries) {
    const std::string name = entry.at("name");
    const auto file = folder.write("a.yaml", config({"show", name}).output);
    const auto result = config({"check", name, file});
    EXPECT_EQ(result.exit_code, 0) << name << ": " << result.errors;
    EXPECT_EQ(result.output, file.string() + ": fits " + name + "\n");
  }
}

TEST(ConfigList, NamesEverythingThatIsBuiltIn) {
  const std::string listed = config({"list"}).output;
  const json built_in = json::parse(run_arbox({"plugins", "list", "--json"}).output).at("built_in");
  EXPECT_GE(built_in.size(), 6U);
  for (const json& entry : built_in) {
    const std::string name =
        entry.at("kind").get<std::string>() + "/" + entry.at("name").get<std::string>();
    EXPECT_THAT(listed, HasSubstr("\n" + name + " "))
        << "options_names() in cli/options_catalog.cpp does not list it";
    EXPECT_THAT(listed, HasSubstr(entry.at("help").get<std::string>()));
  }
}

TEST(ConfigCheck, TellsEveryViolationInOneLine) {
  const TemporaryDirectory folder;
  const auto file = folder.write("a.yaml", "patience: 99\npatence: 1\n");
  expect_one_line_error(config({"check", "detector/blind", file}), 1,
                        {"a.yaml:1: patience: expected integer from 0 to 60 (s), got '99'",
                         "a.yaml:2: unknown key 'patence', nearest is 'patience'"});
}

TEST(ConfigCheck, TellsWhatItCannotRead) {
  const TemporaryDirectory folder;
  expect_one_line_error(config({"check", "detector/blind", folder / "none.yaml"}), 1,
                        {"none.yaml: cannot read"});
  expect_one_line_error(config({"check", "detector/blind", folder.path()}), 1, {"folder"});
  expect_one_line_error(config({"check", "detector/blind", folder.write("b.yaml", "a: [1\n\n\n")}),
                        1, {"b.yaml:", "not YAML"});
}

TEST(Config, RefusesAnUnknownName) {
  expect_one_line_error(
      config({"show", "detector/blnd"}), 2,
      {"unknown options 'detector/blnd', nearest is 'detector/blind'", "arbox config show --help"});
}

}  // namespace
