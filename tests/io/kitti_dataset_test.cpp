#include "arbox/io/kitti_dataset.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "arbox/io/file.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_check.h"
#include "arbox/io/kitti_label.h"
#include "io/expect_refusal.h"
#include "io/made_kitti.h"

namespace {

using namespace arbox::io;
using arbox::testing::expect_refusal;
using arbox::testing::TemporaryDirectory;
using Names = std::vector<std::string>;

const KittiFileReport& kind(const KittiSplitReport& report, const std::string& name) {
  return *std::find_if(report.files.begin(), report.files.end(),
                       [&](const auto& files) { return files.kind == name; });
}

TEST(KittiDataset, SplitsAndFramesAreListed) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  const KittiDataset dataset = KittiDataset::open(folder.path());
  EXPECT_EQ(dataset.splits(), (Names{"train", "val", "training"}));
  EXPECT_EQ(dataset.frames("train"), (Names{"000001", "000003"}));
  EXPECT_EQ(dataset.frames("training"), (Names{"000001", "000002", "000003"}));
  expect_refusal([&] { dataset.frames("trian"); }, {"train, val, training", "'trian'"});
}

TEST(KittiDataset, AFrameHoldsAllThatIsThere) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  const KittiDataset dataset = KittiDataset::open(folder.path());
  const KittiFrame frame = dataset.load("val", "000002");
  EXPECT_EQ(frame.id, "000002");
  EXPECT_EQ(frame.cloud.channels, Names{"intensity"});
  EXPECT_EQ(frame.cloud.values, (std::vector<float>{1, 2, 3, 0.5}));
  EXPECT_EQ(frame.labels.size(), 3u);
  EXPECT_EQ(frame.plane->offset, 1.65);
  EXPECT_EQ(frame.image_size, (ImageSize{1242, 375}));
  const KittiFrame bare = dataset.load("train", "000003");
  EXPECT_FALSE(bare.plane);
  EXPECT_FALSE(bare.image_size);
  EXPECT_TRUE(bare.image.empty());
  expect_refusal([&] { dataset.load("train", "000009"); }, {"000009.bin", "no such file"});
}

TEST(KittiDataset, TestSplitsAreInTheTestingFolderWithoutLabels) {
  const TemporaryDirectory folder;
  folder.write("ImageSets/test.txt", "000007\n");
  folder.write("testing/velodyne/000007.bin", arbox::testing::kMadeScan);
  folder.write("testing/calib/000007.txt", arbox::testing::kMadeCalibration);
  const KittiDataset dataset = KittiDataset::open(folder.path());
  EXPECT_EQ(dataset.splits(), (Names{"test", "testing"}));
  EXPECT_TRUE(dataset.load("test", "000007").labels.empty());
  const KittiSplitReport report = check_kitti_split(dataset, "test");
  EXPECT_EQ(report.files.size(), 4u);
  EXPECT_TRUE(kind(report, "calib").missing.empty());
}

TEST(KittiDataset, WhatIsNoRootIsRefusedWithTheMend) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  expect_refusal([&] { KittiDataset::open(folder / "training"); }, {"parent folder"});
  expect_refusal([&] { KittiDataset::open(folder / "none"); }, {"does not exist"});
  expect_refusal([&] { KittiDataset::open(folder / "ImageSets/train.txt"); }, {"a file"});
  expect_refusal([&] { KittiDataset::open(folder / "ImageSets"); }, {"training or testing"});
}

TEST(KittiSplit, BadNamesAreRefusedWithTheirLine) {
  EXPECT_EQ(parse_kitti_split("000001\r\n\n 000002 \n", "s"), (Names{"000001", "000002"}));
  EXPECT_TRUE(parse_kitti_split("", "s").empty());
  const auto refused = [](const std::string& text, const Names& parts) {
    expect_refusal([&] { parse_kitti_split(text, "val.txt"); }, parts);
  };
  refused("000001\n../../etc/passwd\n", {"val.txt:2", "frame name", "'../../etc/passwd'"});
  refused("000001 1\n", {"val.txt:1", "frame name"});
  refused("..\n", {"val.txt:1", "frame name"});
  refused("1\n2\n1\n", {"val.txt:3", "once", "'1' a second time"});
}

TEST(KittiScan, FilesOfAnotherSizeAreRefused) {
  const TemporaryDirectory folder;
  expect_refusal([&] { read_kitti_scan(folder.write("a.bin", "")); }, {"a.bin", "16", "0 bytes"});
  expect_refusal([&] { read_kitti_scan(folder.write("b.bin", std::string(20, 'x'))); },
                 {"b.bin", "16", "20 bytes"});
  expect_refusal([&] { read_kitti_scan(folder.path()); }, {"directory"});
  expect_refusal([&] { count_kitti_points(folder.path()); }, {"directory"});
  EXPECT_EQ(count_kitti_points(folder.write("c.bin", std::string(64, 'x'))), 4);
}

TEST(PngSize, IsReadFromTheHeader) {
  using arbox::testing::kMadePngHeader;
  EXPECT_EQ(parse_png_size(kMadePngHeader, "i"), (ImageSize{1242, 375}));
  expect_refusal([] { parse_png_size("", "i.png"); }, {"i.png", "PNG", "0 bytes"});
  expect_refusal([] { parse_png_size(std::string(40, 'x'), "i.png"); }, {"another beginning"});
  std::string damaged = kMadePngHeader;
  damaged[19] = 1;
  expect_refusal([&] { parse_png_size(damaged, "i.png"); }, {"damaged"});
  damaged[16] = damaged[17] = 127;
  expect_refusal([&] { parse_png_size(damaged, "i.png"); }, {"1048576"});
}

TEST(KittiCheck, MissingAndBrokenFilesAreReportedWithTheirFirstBadLine) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  folder.write("ImageSets/train.txt", "000001\n000003\n000004\n");
  folder.write("training/label_2/000001.txt", arbox::testing::kMadeLabels + "Car 1 2\nCar 3\n");
  folder.write("training/velodyne/000003.bin", "short");
  folder.write("training/image_2/000001.png", "GIF89a");
  const KittiDataset dataset = KittiDataset::open(folder.path());
  for (const int threads : {1, 2}) {
    int done = 0;
    const KittiSplitReport report = check_kitti_split(
        dataset, "train", threads, threads == 1 ? [&] { ++done; } : std::function<void()>());
    EXPECT_EQ(done, threads == 1 ? 3 : 0);
    EXPECT_EQ(report.frames, 3);
    EXPECT_EQ(report.objects,
              (std::map<std::string, std::int64_t>{{"Car", 1}, {"Cyclist", 1}, {"DontCare", 1}}));
    EXPECT_EQ(kind(report, "velodyne").missing, Names{"000004"});
    EXPECT_EQ(kind(report, "velodyne").present, 2);
    ASSERT_EQ(kind(report, "velodyne").broken.size(), 1u);
    EXPECT_NE(kind(report, "velodyne").broken[0].find("000003.bin"), std::string::npos);
    ASSERT_EQ(kind(report, "label_2").broken.size(), 1u);
    EXPECT_NE(kind(report, "label_2").broken[0].find("000001.txt:4: expected 15 fields"),
              std::string::npos);
    EXPECT_EQ(kind(report, "image_2").broken.size(), 1u);
    EXPECT_EQ(kind(report, "planes").missing, (Names{"000003", "000004"}));
    EXPECT_FALSE(kind(report, "planes").required);
  }
}

TEST(KittiCheck, ABrokenSplitFileIsReported) {
  const TemporaryDirectory folder;
  arbox::testing::make_kitti(folder);
  folder.write("ImageSets/val.txt", "a b\n");
  const auto report = check_kitti_split(KittiDataset::open(folder.path()), "val");
  EXPECT_NE(report.problem.find("val.txt:1"), std::string::npos);
  EXPECT_EQ(report.frames, 0);
}

TEST(KittiData, TheSampleFramesAreWhole) {
  ARBOX_REQUIRE_DATA(root, "kitti");
  const KittiDataset dataset = KittiDataset::open(root);
  const KittiSplitReport report = check_kitti_split(dataset, "sample");
  EXPECT_EQ(report.frames, 13);
  for (const auto& files : report.files) {
    EXPECT_TRUE(files.broken.empty()) << files.kind << ": " << files.broken[0];
    EXPECT_TRUE(files.missing.empty() || !files.required) << files.kind;
  }
  EXPECT_EQ(kind(report, "image_2").present, 5);
  EXPECT_EQ(kind(report, "planes").present, 8);
  for (const auto& [split, frames] :
       {std::pair("train", 3712), {"val", 3769}, {"test", 7518}, {"trainval", 7481}}) {
    EXPECT_EQ(dataset.frames(split).size(), static_cast<std::size_t>(frames)) << split;
  }
}

TEST(KittiData, EveryLabelledBoxOfTheSampleHoldsPoints) {
  ARBOX_REQUIRE_DATA(root, "kitti");
  const KittiDataset dataset = KittiDataset::open(root);
  for (const std::string& id : dataset.frames("sample")) {
    const KittiFrame frame = dataset.load("sample", id);
    EXPECT_EQ(frame.cloud.columns(), 4u);
    for (const auto& labelled : to_detections(frame.labels, frame.calibration)) {
      const auto view = frame.cloud.view();
      bool found = false;
      for (std::size_t i = 0; i < view.size() && !found; ++i) {
        found = contains(labelled.box, view.position(i).cast<double>());
      }
      EXPECT_TRUE(found) << id << " " << labelled.label;
    }
    if (!frame.image.empty()) {
      EXPECT_EQ(known_image_size(frame.calibration), frame.image_size) << id;
    }
  }
}

struct AllFrames {
  TemporaryDirectory folder;
  explicit AllFrames(const std::filesystem::path& archive) {
    const auto result =
        arbox::testing::run("/bin/tar", {"-xzf", archive.string(), "-C", folder.path().string()});
    EXPECT_EQ(result.exit_code, 0) << result.errors;
  }
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(KittiData, AllLabelsAndCalibrationsOfTheBenchmarkRead) {
  ARBOX_REQUIRE_DATA(archive, "kitti/kitti_object_labels_calib_all7481.tar.gz");
  const AllFrames all(archive);
  const KittiDataset dataset = KittiDataset::open(all.folder.path());
  const KittiSplitReport report = check_kitti_split(dataset, "training");
  EXPECT_EQ(report.frames, 7481);
  EXPECT_TRUE(kind(report, "label_2").broken.empty());
  EXPECT_TRUE(kind(report, "calib").broken.empty());
  EXPECT_EQ(report.objects, (std::map<std::string, std::int64_t>{{"Car", 28742},
                                                                 {"Pedestrian", 4487},
                                                                 {"Van", 2914},
                                                                 {"Cyclist", 1627},
                                                                 {"Truck", 1094},
                                                                 {"Misc", 973},
                                                                 {"Tram", 511},
                                                                 {"Person_sitting", 222},
                                                                 {"DontCare", 11295}}));

  // The whole chain to the image must land on the 2-D boxes and angles that people drew.
  std::vector<double> edge_errors, angle_errors;
  Eigen::Vector3d car_sizes = Eigen::Vector3d::Zero();
  for (const std::string& id : dataset.frames("training")) {
    const KittiPaths paths = dataset.paths("training", id);
    const KittiCalibration calibration = read_kitti_calibration(paths.calibration);
    const ImageSize image = known_image_size(calibration).value();
    const auto labels = read_kitti_labels(paths.label);
    for (const KittiObject& object : labels) {
      EXPECT_LT(object.right, image.width) << id;
      if (object.type != "Car") continue;
      car_sizes += Eigen::Vector3d(object.height, object.width, object.length) / 28742.0;
      KittiObject again = to_kitti_object(to_box(object, calibration), calibration);
      EXPECT_NEAR(arbox::geometry::wrap_angle(again.rotation_y - object.rotation_y), 0, 1e-12);
      EXPECT_LT(std::hypot(again.x - object.x, again.y - object.y, again.z - object.z), 1e-9);
      const auto whole = projected_box(again, calibration);
      const auto cut = whole ? clipped(*whole, image) : std::nullopt;
      if (object.truncation > 0.1 || object.occlusion > 0 || !cut) continue;
      edge_errors.push_back(std::abs(cut->left - object.left));
      edge_errors.push_back(std::abs(cut->right - object.right));
      edge_errors.push_back(std::abs(cut->bottom - object.bottom));
      angle_errors.push_back(
          std::abs(arbox::geometry::wrap_angle(observation_angle(again) - object.alpha)));
    }
  }
  EXPECT_GT(angle_errors.size(), 10000u);
  EXPECT_LT(median(edge_errors), 3.0);
  EXPECT_LT(median(angle_errors), 0.02);
  EXPECT_TRUE(car_sizes.isApprox(Eigen::Vector3d(1.526, 1.629, 3.884), 1e-3))
      << car_sizes.transpose();
}

}  // namespace
