#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "arbox/io/kitti_label.h"
#include "support/program.h"

namespace arbox::testing {
namespace {

const std::filesystem::path kExamples = ARBOX_EXAMPLES;

TEST(MadeStreet, IsWhatTheExampleDataHolds) {
  const TemporaryDirectory folder;
  const RunResult result = run(ARBOX_MAKE_STREET, {folder.path().string()});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  for (const char* name :
       {"street.bin", "kitti/training/calib/000000.txt", "kitti/training/label_2/000000.txt"}) {
    EXPECT_TRUE(slurp(folder / name) == slurp(kExamples / "data" / name))
        << name << " differs: write it anew with make_street examples/data";
  }
}

TEST(MadeStreet, LabelsTellHowMuchIsSeen) {
  const auto labels = io::read_kitti_labels(kExamples / "data/kitti/training/label_2/000000.txt");
  int levels[3] = {};
  for (const auto& label : labels) {
    EXPECT_GE(label.truncation, 0.0);
    EXPECT_LE(label.truncation, 1.0);
    ASSERT_GE(label.occlusion, 0);
    ASSERT_LE(label.occlusion, 2);
    ++levels[label.occlusion];
  }
  for (const int count : levels) EXPECT_GT(count, 0);
}

TEST(ClusterFitPage, ListsTheOptionsAsTheProgramDescribesThem) {
  const RunResult table = run_arbox({"config", "show", "detector/cluster_fit", "--table"});
  ASSERT_EQ(table.exit_code, 0) << table.errors;
  const std::string page = slurp(ARBOX_DOCS "/detectors/cluster_fit.md");
  EXPECT_NE(page.find(table.output), std::string::npos)
      << "the page must hold what arbox config show detector/cluster_fit --table prints:\n"
      << table.output;
}

}  // namespace
}  // namespace arbox::testing
