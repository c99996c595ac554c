#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::TemporaryDirectory;
using nlohmann::json;
using ::testing::HasSubstr;

const std::filesystem::path kPlugin = ARBOX_DETECTOR_PLUGIN;

TEST(PluginsCheck, TellsWhatAFittingPluginIs) {
  const auto result = run_arbox({"plugins", "check", kPlugin});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.output,
            kPlugin.string() + ": fits this build; detector blind, version 0.1.0, Apache-2.0\n");
}

TEST(PluginsCheck, GivesJson) {
  const auto result = run_arbox({"plugins", "check", kPlugin, "--json"});
  const json plugin = json::parse(result.output);
  EXPECT_EQ(plugin.at("kind"), "detector");
  EXPECT_EQ(plugin.at("name"), "blind");
  EXPECT_EQ(plugin.at("version"), "0.1.0");
  EXPECT_EQ(plugin.at("licence"), "Apache-2.0");
}

TEST(PluginsCheck, TakesARelativePathThatItIsGiven) {
  const auto result = run_arbox({"plugins", "check", kPlugin.filename()},
                                {.working_directory = kPlugin.parent_path()});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
}

TEST(PluginsCheck, RefusesInOneLine) {
  const TemporaryDirectory folder;
  expect_one_line_error(
      run_arbox({"plugins", "check", folder.write("libarbox_detector_text.so", "words\nwords")}), 1,
      {"libarbox_detector_text.so", "cannot be loaded"});
  expect_one_line_error(run_arbox({"plugins", "check", folder / "none.so"}), 1, {"no such file"});
  expect_one_line_error(run_arbox({"plugins", "check"}), 2, {"file"});
}

TEST(PluginsList, ShowsFoundAndRefusedPlugins) {
  const TemporaryDirectory folder;
  const auto text = folder.write("libarbox_detector_text.so", "words");
  std::filesystem::copy_file(kPlugin, folder / kPlugin.filename().string());
  const auto result = run_arbox({"plugins", "list", "--json"},
                                {.environment = {{"ARBOX_PLUGIN_PATH", folder.path()}}});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const json plugins = json::parse(result.output).at("plugins");
  ASSERT_EQ(plugins.size(), 2U);
  EXPECT_EQ(plugins[0].at("name"), "blind");
  EXPECT_EQ(plugins[1].at("file"), text.string());
  EXPECT_THAT(plugins[1].at("error").get<std::string>(), HasSubstr("cannot be loaded"));
}

TEST(PluginsList, NamesTheFoldersThatItLookedIn) {
  const auto result =
      run_arbox({"plugins", "list"}, {.environment = {{"ARBOX_PLUGIN_PATH", "/nonexistent"}}});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, HasSubstr("looked in: /nonexistent /"));
  expect_one_line_error(
      run_arbox({"plugins", "list"}, {.environment = {{"ARBOX_PLUGIN_PATH", "here"}}}), 1,
      {"ARBOX_PLUGIN_PATH", "absolute"});
}

TEST(PluginFlag, MakesAPluginKnownToEveryCommand) {
  const auto result = run_arbox({"config", "list", "--plugin", kPlugin});
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("detector/blind"));
  expect_one_line_error(run_arbox({"config", "list", "--plugin", "/none.so"}), 1, {"/none.so"});
}

}  // namespace
