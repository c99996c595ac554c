#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "support/program.h"

namespace {

namespace fs = std::filesystem;
using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::RunOptions;
using arbox::testing::RunResult;
using arbox::testing::slurp;
using arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

std::map<std::string, std::string> bytes(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[entry.path().lexically_relative(folder).string()] = slurp(entry.path());
    }
  }
  return files;
}

RunResult simulate(const fs::path& output, const std::vector<std::string>& more,
                   const RunOptions& options = {}) {
  std::vector<std::string> arguments = {"simulate", "street", "--output", output.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_arbox(arguments, options);
}

TEST(SimulateStreet, AKilledRunGoesOnToTheSameBytes) {
  const TemporaryDirectory folder;
  RunOptions hurried;
  hurried.timeout_seconds = 0.8;
  const RunResult killed = simulate(folder / "killed", {"--scenes", "8", "--seed", "3"}, hurried);
  const RunResult again = simulate(folder / "killed", {"--scenes", "8", "--seed", "3"});
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_THAT(again.output, HasSubstr("scenes written"));
  EXPECT_EQ(simulate(folder / "whole", {"--scenes", "8", "--seed", "3"}).exit_code, 0);
  EXPECT_TRUE(killed.timed_out || killed.exit_code == 0);
  EXPECT_EQ(bytes(folder / "killed"), bytes(folder / "whole"));
}

TEST(SimulateStreet, InfoReadsTheFolder) {
  const TemporaryDirectory folder;
  const RunResult made =
      simulate(folder / "out", {"--scenes", "2", "--lidar", "spinning16", "--json"});
  ASSERT_EQ(made.exit_code, 0);
  EXPECT_THAT(made.output, HasSubstr("\"written\": 2"));
  const RunResult info = run_arbox({"info", "kitti", (folder / "out").string()});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.output, HasSubstr("trainval: 2 frames"));
  EXPECT_THAT(info.output, ::testing::Not(HasSubstr("broken:")));
}

TEST(SimulateStreet, ConfigurationFilesCountAndFlagsWinOverThem) {
  const TemporaryDirectory folder;
  const fs::path config = folder.write("options.yaml", "lidar: spinning16\nstreet:\n  people: 0\n");
  ASSERT_EQ(simulate(folder / "out", {"--scenes", "1", "--config", config.string()}).exit_code, 0);
  EXPECT_THAT(slurp(folder / "out/simulation.yaml"), HasSubstr("lidar: spinning16"));
  ASSERT_EQ(simulate(folder / "flags",
                     {"--scenes", "1", "--config", config.string(), "--lidar", "spinning32"})
                .exit_code,
            0);
  EXPECT_THAT(slurp(folder / "flags/simulation.yaml"), HasSubstr("lidar: spinning32"));
}

TEST(SimulateStreet, AKilledRunWithPicturesGoesOnToTheSameBytes) {
  const TemporaryDirectory folder;
  const std::vector<std::string> few = {"--scenes",        "4", "--seed", "3", "--images",
                                        "--image-samples", "1"};
  RunOptions hurried;
  hurried.timeout_seconds = 1.5;
  const RunResult killed = simulate(folder / "killed", few, hurried);
  EXPECT_TRUE(killed.timed_out || killed.exit_code == 0);
  EXPECT_EQ(simulate(folder / "killed", few).exit_code, 0);
  EXPECT_EQ(simulate(folder / "whole", few).exit_code, 0);
  EXPECT_EQ(bytes(folder / "killed"), bytes(folder / "whole"));
}

TEST(SimulateStreet, ViewAndInfoReadThePictures) {
  const TemporaryDirectory folder;
  const fs::path config = folder.write("options.yaml", "images: true\nimage:\n  samples: 1\n");
  ASSERT_EQ(simulate(folder / "out", {"--scenes", "2", "--config", config.string()}).exit_code, 0);
  const fs::path training = folder / "out/training";
  const RunResult view = run_arbox({"view", "--cloud", (training / "velodyne/000000.bin").string(),
                                    "--labels", (training / "label_2/000000.txt").string(),
                                    "--calib", (training / "calib/000000.txt").string(), "--image",
                                    (training / "image_2/000000.png").string(), "--output",
                                    (folder / "view.png").string()});
  EXPECT_EQ(view.exit_code, 0) << view.errors;
  EXPECT_TRUE(fs::exists(folder / "view.png"));
  const RunResult info = run_arbox({"info", "kitti", (folder / "out").string()});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.output, ::testing::Not(HasSubstr("broken:")));
}

TEST(SimulateStreet, BadInputIsRefusedInOneLine) {
  const TemporaryDirectory folder;
  expect_one_line_error(simulate(folder / "out", {}), 2, {"--scenes"});
  expect_one_line_error(simulate(folder / "out", {"--scenes", "0"}), 2, {"--scenes"});
  expect_one_line_error(simulate(folder / "out", {"--scenes", "1", "--lidar", "radar"}), 2,
                        {"lidar"});
  expect_one_line_error(simulate(folder / "out", {"--scenes", "1", "--street-people", "-1"}), 2,
                        {"people"});
  expect_one_line_error(
      simulate(folder / "out", {"--scenes", "1", "--images", "--image-samples", "0"}), 2,
      {"samples"});
  const fs::path config = folder.write("options.yaml", "lidars: spinning16\n");
  const RunResult unknown =
      simulate(folder / "out", {"--scenes", "1", "--config", config.string()});
  EXPECT_NE(unknown.exit_code, 0);
  EXPECT_THAT(unknown.errors, HasSubstr("nearest is 'lidar'"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
