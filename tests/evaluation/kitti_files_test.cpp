#include "arbox/evaluation/kitti_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "arbox/base/error.h"
#include "support/program.h"

namespace arbox::evaluation {
namespace {

using arbox::testing::TemporaryDirectory;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kLabel[] =
    "Car 0.10 1 -0.50 100.00 150.00 200.00 210.00 1.50 1.60 4.00 1.00 1.70 20.00 0.40\n"
    "DontCare -1 -1 -10 500.00 150.00 520.00 170.00 -1 -1 -1 -1000 -1000 -1000 -10\n";
constexpr char kResult[] =
    "Car -1 -1 -0.52 101.00 150.00 200.00 210.00 1.51 1.60 4.01 1.00 1.71 20.10 0.41 0.93 \n";

struct Folders {
  TemporaryDirectory root;
  std::filesystem::path labels = root / "labels";
  std::filesystem::path results = root / "results";
  Folders() {
    for (const char* name : {"000003", "000001"}) {
      root.write("labels/" + std::string(name) + ".txt", kLabel);
      root.write("results/" + std::string(name) + ".txt", kResult);
    }
    root.write("labels/000002.txt", kLabel);
  }
};

template <class Expected>
std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Expected& error) {
    return error.what();
  }
  return "no such error";
}

TEST(KittiFiles, ReadsTheFramesThatHaveResultsInOrder) {
  const Folders folders;
  folders.root.write("results/notes.md", "not a result");
  const KittiFrames read = read_kitti_frames(folders.labels, folders.results);
  EXPECT_THAT(read.names, ElementsAre("000001", "000003"));
  ASSERT_EQ(read.frames[0].labels.size(), 2u);
  EXPECT_EQ(read.frames[0].labels[0].z, 20.0);
  ASSERT_EQ(read.frames[0].predictions.size(), 1u);
  EXPECT_EQ(read.frames[0].predictions[0].score, 0.93);
}

TEST(KittiFiles, TellOfEveryFrameThatIsRead) {
  const Folders folders;
  std::atomic<int> read = 0;
  read_kitti_frames(folders.labels, folders.results, {}, 2, [&] { ++read; });
  EXPECT_EQ(read, 2);
  EXPECT_THAT(kitti_frame_names(folders.results), ElementsAre("000001", "000003"));
}

TEST(KittiFiles, ReadsTheFramesOfASplit) {
  const Folders folders;
  const auto split = folders.root.write("split.txt", "000003\n\n000001\r\n");
  EXPECT_THAT(read_kitti_frames(folders.labels, folders.results, split).names,
              ElementsAre("000003", "000001"));
}

TEST(KittiFiles, EmptyResultFileIsAFrameWithoutDetections) {
  const Folders folders;
  folders.root.write("results/000002.txt", "");
  EXPECT_TRUE(read_kitti_frames(folders.labels, folders.results).frames[1].predictions.empty());
}

TEST(KittiFiles, MissingFilesAreNamed) {
  const Folders folders;
  const auto split = folders.root.write("split.txt", "000001\n000002\n");
  EXPECT_THAT(error_of<IoError>([&] { read_kitti_frames(folders.labels, folders.results, split); }),
              HasSubstr("results/000002.txt: no such result file; write an empty one"));
  folders.root.write("results/000009.txt", kResult);
  EXPECT_THAT(error_of<IoError>([&] { read_kitti_frames(folders.labels, folders.results); }),
              HasSubstr("labels/000009.txt: no such label file"));
  EXPECT_THAT(error_of<IoError>([&] { read_kitti_frames(folders.root / "no", folders.results); }),
              HasSubstr("expected a folder of label files, got nothing"));
  EXPECT_THAT(error_of<IoError>([&] { read_kitti_frames(folders.labels, split); }),
              HasSubstr("expected a folder of result files, got a file"));
}

TEST(KittiFiles, FirstBadFrameIsReportedWhateverTheThreads) {
  const Folders folders;
  for (int i = 100; i < 300; ++i) {
    const std::string name = std::to_string(i) + ".txt";
    folders.root.write("labels/" + name, kLabel);
    folders.root.write("results/" + name, i == 150 || i == 299 ? "Car nonsense\n" : kResult);
  }
  for (const int threads : {1, 2, 8}) {
    EXPECT_THAT(error_of<FormatError>([&] {
                  read_kitti_frames(folders.labels, folders.results, std::nullopt, threads);
                }),
                HasSubstr("150.txt:1"));
  }
}

TEST(KittiFiles, RefusesSplitsAndFoldersThatNameNothing) {
  const Folders folders;
  const auto empty = folders.root.write("empty.txt", "\n \n");
  EXPECT_THAT(
      error_of<FormatError>([&] { read_kitti_frames(folders.labels, folders.results, empty); }),
      HasSubstr("expected frame names"));
  const auto doubled = folders.root.write("doubled.txt", "000001\n000001\n");
  EXPECT_THAT(
      error_of<FormatError>([&] { read_kitti_frames(folders.labels, folders.results, doubled); }),
      HasSubstr("000001 is listed twice"));
  std::filesystem::create_directory(folders.root / "nothing");
  EXPECT_THAT(
      error_of<IoError>([&] { read_kitti_frames(folders.labels, folders.root / "nothing"); }),
      HasSubstr("holds no result file"));
}

}  // namespace
}  // namespace arbox::evaluation
