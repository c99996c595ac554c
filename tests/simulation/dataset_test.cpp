#include "arbox/simulation/street_dataset.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "arbox/base/error.h"
#include "arbox/drawing/image.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/kitti_label.h"

namespace arbox::simulation {
namespace {

namespace fs = std::filesystem;

class StreetDataset : public testing::Test {
 protected:
  StreetDataset() {
    root_ = fs::temp_directory_path() /
            ("arbox_streets_" +
             std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
  }
  ~StreetDataset() override { fs::remove_all(root_); }

  static std::map<std::string, std::string> bytes(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) {
        files[entry.path().lexically_relative(folder).string()] = io::read_file(entry.path());
      }
    }
    return files;
  }

  fs::path root_;
};

TEST_F(StreetDataset, TheSameSeedGivesTheSameBytesAtAnyThreadCount) {
  write_street_dataset({}, 4, 5, root_ / "one", 1);
  write_street_dataset({}, 4, 5, root_ / "three", 3);
  EXPECT_EQ(bytes(root_ / "one"), bytes(root_ / "three"));
  write_street_dataset({}, 5, 5, root_ / "other", 2);
  EXPECT_NE(bytes(root_ / "one"), bytes(root_ / "other"));
}

TEST_F(StreetDataset, AStoppedRunGoesOnAndEndsWithTheSameBytes) {
  write_street_dataset({}, 4, 4, root_ / "whole", 2);
  const fs::path part = root_ / "part";
  write_street_dataset({}, 4, 4, part, 2);
  fs::remove(part / "training/velodyne/000002.bin");
  fs::remove(part / "training/calib/000002.txt");
  fs::remove(part / "training/velodyne/000003.bin");
  fs::remove(part / "ImageSets/val.txt");
  io::write_file(part / "training/velodyne/000002.bin.part77", "half a scan");
  const StreetDatasetReport report = write_street_dataset({}, 4, 4, part, 2);
  EXPECT_EQ(report.written, 2);
  EXPECT_EQ(report.found, 2);
  EXPECT_EQ(bytes(root_ / "whole"), bytes(part));
}

TEST_F(StreetDataset, TheLoaderReadsEverythingBack) {
  write_street_dataset({}, 6, 3, root_, 2);
  const io::KittiDataset dataset = io::KittiDataset::open(root_);
  EXPECT_EQ(dataset.frames("train"), (std::vector<std::string>{"000000", "000002"}));
  EXPECT_EQ(dataset.frames("val"), std::vector<std::string>{"000001"});
  std::size_t labels = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const io::KittiFrame frame = dataset.load("trainval", "00000" + std::to_string(i));
    const StreetScan scan = street_scan({}, 6, i);
    EXPECT_EQ(frame.cloud.values, scan.cloud().values);
    ASSERT_TRUE(frame.plane);
    EXPECT_NEAR(io::plane_in_lidar(*frame.plane, frame.calibration).offset,
                scan.scene.ground_offset, 1e-4);
    ASSERT_EQ(frame.labels.size(), scan.labels.image.size());
    EXPECT_EQ(frame.image_size, scan.camera.image);
    const auto boxes = scan.boxes();
    const auto read = io::to_detections(frame.labels, frame.calibration);
    ASSERT_EQ(read.size(), boxes.size());
    labels += boxes.size();
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      EXPECT_LT((read[k].box.center - boxes[k].center).norm(), 0.02);
    }
    const auto around = io::read_kitti_labels(root_ / "training/label_360" / (frame.id + ".txt"));
    EXPECT_EQ(around.size() + boxes.size(), scan.scene.objects.size());
  }
  EXPECT_GT(labels, 0u);
}

TEST_F(StreetDataset, AStreamGivesTheScansOfTheFiles) {
  StreetStream stream({}, 6, 1, 2);
  EXPECT_EQ(stream.next().cloud().values, street_scan({}, 6, 1).cloud().values);
  const StreetScan third = stream.next();
  EXPECT_EQ(third.cloud().values, street_scan({}, 6, 3).cloud().values);
  EXPECT_EQ(third.boxes().size(), third.classes().size());
  EXPECT_EQ(third.boxes(true).size(), third.scene.objects.size());
}

TEST_F(StreetDataset, OtherOptionsInAFolderThatWasBegunAreRefused) {
  write_street_dataset({}, 4, 1, root_, 1);
  EXPECT_THROW(write_street_dataset({}, 5, 1, root_, 1), ConfigError);
  StreetScanOptions options;
  options.street.people = 2.0;
  EXPECT_THROW(write_street_dataset(options, 4, 1, root_, 1), ConfigError);
  EXPECT_EQ(write_street_dataset({}, 4, 2, root_, 1).found, 1);
}

/// Rough pictures, as tests have little time.
StreetDatasetOptions with_images() {
  StreetDatasetOptions options;
  options.images = true;
  options.image.samples = 1;
  return options;
}

TEST_F(StreetDataset, PicturesChangeNothingElse) {
  write_street_dataset({}, 4, 3, root_ / "without", 1);
  write_street_dataset(with_images(), 4, 3, root_ / "with", 2);
  auto with = bytes(root_ / "with"), without = bytes(root_ / "without");
  for (const char* name : {"000000", "000001", "000002"}) {
    EXPECT_EQ(with.erase("training/image_2/" + std::string(name) + ".png"), 1u);
  }
  EXPECT_NE(with.extract("simulation.yaml").mapped(), without.extract("simulation.yaml").mapped());
  EXPECT_EQ(with, without);
}

TEST_F(StreetDataset, WithoutPicturesTheOptionsOfTheFolderDoNotNameThem) {
  write_street_dataset({}, 4, 1, root_, 1);
  EXPECT_EQ(io::read_file(root_ / "simulation.yaml").find("images:"), std::string::npos);
  EXPECT_FALSE(fs::exists(root_ / "training/image_2"));
}

TEST_F(StreetDataset, PicturesHaveTheSameBytesAtAnyThreadCountAndAfterAStop) {
  write_street_dataset(with_images(), 4, 3, root_ / "one", 1);
  const fs::path two = root_ / "two";
  write_street_dataset(with_images(), 4, 3, two, 2);
  EXPECT_EQ(bytes(root_ / "one"), bytes(two));
  fs::remove(two / "training/velodyne/000000.bin");
  fs::remove(two / "training/velodyne/000002.bin");
  fs::remove(two / "training/image_2/000002.png");
  io::write_file(two / "training/image_2/000002.png.part77", "half a picture");
  EXPECT_EQ(write_street_dataset(with_images(), 4, 3, two, 2).written, 2);
  EXPECT_EQ(bytes(root_ / "one"), bytes(two));
}

TEST_F(StreetDataset, PicturesLaterAreRefused) {
  write_street_dataset({}, 4, 1, root_, 1);
  EXPECT_THROW(write_street_dataset(with_images(), 4, 1, root_, 1), ConfigError);
}

TEST_F(StreetDataset, TheLoaderFindsPicturesOfTheCamerasSize) {
  write_street_dataset(with_images(), 6, 2, root_, 2);
  const io::KittiDataset dataset = io::KittiDataset::open(root_);
  for (const std::uint64_t i : {0u, 1u}) {
    const io::KittiFrame frame = dataset.load("trainval", "00000" + std::to_string(i));
    ASSERT_FALSE(frame.image.empty());
    const drawing::Image picture = drawing::read_image(frame.image);
    const StreetScan scan = street_scan({}, 6, i);
    EXPECT_EQ((io::ImageSize{picture.width, picture.height}), scan.camera.image);
    EXPECT_EQ(frame.image_size, scan.camera.image);
    EXPECT_EQ(picture.pixels,
              render_camera_image(scan.scene, scan.camera, {.samples = 1}).picture.pixels);
  }
}

TEST_F(StreetDataset, OptionsOutOfRangeAreRefused) {
  StreetDatasetOptions rough = with_images();
  rough.image.samples = 0;
  EXPECT_THROW(write_street_dataset(rough, 0, 1, root_), ConfigError);
  EXPECT_THROW(write_street_dataset({}, 0, 0, root_), InvalidArgument);
  EXPECT_THROW(write_street_dataset({}, 0, -3, root_), InvalidArgument);
  EXPECT_THROW(write_street_dataset({}, 0, 1000001, root_), InvalidArgument);
  StreetScanOptions options;
  options.camera = 9;
  EXPECT_THROW(street_scan(options, 0, 0), ConfigError);
  options = {};
  options.street.traffic = -1.0;
  EXPECT_THROW(street_scan(options, 0, 0), ConfigError);
  options = {};
  options.street = {.inner_city = 0, .residential = 0, .road = 0, .campus = 0, .highway = 0};
  EXPECT_THROW(street_scan(options, 0, 0), ConfigError);
  EXPECT_FALSE(fs::exists(root_ / "training" / "velodyne" / "000000.bin"));
}

TEST_F(StreetDataset, AFolderThatCannotBeMadeIsAnError) {
  fs::create_directories(root_);
  io::write_file(root_ / "file", "");
  EXPECT_THROW(write_street_dataset({}, 0, 1, root_ / "file" / "below"), IoError);
}

}  // namespace
}  // namespace arbox::simulation
