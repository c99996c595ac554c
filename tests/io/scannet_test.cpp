#include "arbox/io/scannet.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "arbox/io/dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/npy.h"
#include "io/expect_refusal.h"
#include "io/made_scannet.h"

namespace arbox {
namespace {

using io::parse_scannet_aggregation;
using io::parse_scannet_alignment;
using io::parse_scannet_label_map;
using io::parse_scannet_segments;
using testing::expect_refusal;
using testing::RawScan;
using testing::TemporaryDirectory;

RawScan made_scan() {
  RawScan scan{.name = "scene0000_00"};
  scan.cloud.channels = {"r", "g", "b"};
  const auto add = [&](float x, float y, float z, std::uint32_t instance) {
    scan.cloud.values.insert(scan.cloud.values.end(), {x, y, z, 1.0F, 0.0F, 51.0F / 255.0F});
    scan.instances.push_back(instance);
  };
  add(0, 0, 0, 0);
  add(1, 2, 0, 1), add(2, 4, 1, 1), add(1.5F, 3, 0.5F, 1);
  add(-1, 0, 0, 2), add(-2, -1, 0.25F, 2);
  add(5, 5, 5, 3), add(6, 6, 5, 3);
  scan.labels = {{1, "office chair"}, {2, "raw 1"}, {3, "raw 9"}};
  // A quarter turn about z and a shift by (10, 0, 1).
  scan.alignment = "0 -1 0 10 1 0 0 0 0 0 1 1 0 0 0 1";
  return scan;
}

TEST(ScanNet, RawReleaseGivesAlignedBoxesOfTheBenchmarkClasses) {
  const TemporaryDirectory folder;
  testing::write_raw_scan(folder, made_scan(), 1);
  folder.write("scannetv2-labels.combined.tsv", testing::made_label_map());
  folder.write("meta_data/scannetv2_train.txt", "scene0000_00\n");
  const auto dataset = io::open_dataset(folder.path());
  EXPECT_EQ(dataset->layout(), "scannet");
  EXPECT_EQ(dataset->splits(), (std::vector<std::string>{"train", "all"}));
  const auto scene = dataset->load("train", "scene0000_00");
  EXPECT_EQ(scene.frame, io::SceneFrame::kRoom);
  ASSERT_EQ(scene.objects.size(), 2u);  // The wall is no class of the benchmark.
  EXPECT_EQ(scene.objects[0].label, "chair");
  EXPECT_TRUE(scene.objects[0].box.center.isApprox(Eigen::Vector3d(7, 1.5, 1.5)));
  EXPECT_TRUE(scene.objects[0].box.size.isApprox(Eigen::Vector3d(2, 1, 1)));
  EXPECT_EQ(scene.objects[0].heading, io::Heading::kUnknown);
  EXPECT_EQ(scene.objects[1].label, "window");
  EXPECT_DOUBLE_EQ(scene.objects[1].box.size.z(), 1e-6);
  EXPECT_EQ(scene.point_objects, (std::vector<std::int32_t>{-1, 0, 0, 0, -1, -1, 1, 1}));
  EXPECT_EQ(scene.cloud.view().position(1), Eigen::Vector3f(8, 1, 1));
  EXPECT_FLOAT_EQ(scene.cloud.values[5], 0.2F);
  const auto all = io::open_dataset(folder.path(), {.classes = "all"})->load("all", "scene0000_00");
  ASSERT_EQ(all.objects.size(), 3u);
  EXPECT_EQ(all.objects[1].label, "wall");
}

TEST(ScanNet, WithoutAlignmentAndLabelsTheScanStaysAsItIs) {
  const TemporaryDirectory folder;
  RawScan scan = made_scan();
  scan.alignment.clear();
  testing::write_raw_scan(folder, scan);
  folder.write("scannetv2-labels.combined.tsv", testing::made_label_map());
  std::filesystem::remove(folder / "scans/scene0000_00/scene0000_00.aggregation.json");
  const auto scene = io::open_dataset(folder.path())->load("all", "scene0000_00");
  EXPECT_FALSE(scene.labelled);
  EXPECT_TRUE(scene.objects.empty());
  EXPECT_EQ(scene.cloud.view().position(1), Eigen::Vector3f(1, 2, 0));
}

TEST(ScanNet, SegmentsMustMatchTheMesh) {
  const TemporaryDirectory folder;
  testing::write_raw_scan(folder, made_scan());
  folder.write("scannetv2-labels.combined.tsv", testing::made_label_map());
  folder.write("scans/scene0000_00/scene0000_00_vh_clean_2.0.010000.segs.json",
               R"({"segIndices": [1, 2]})");
  expect_refusal([&] { io::open_dataset(folder.path())->load("all", "scene0000_00"); },
                 {"segs.json", "one segment a vertex (8)", "got 2"});
  std::filesystem::remove(folder / "scannetv2-labels.combined.tsv");
  expect_refusal([&] { io::open_dataset(folder.path()); }, {"scannetv2-labels.combined.tsv"});
}

TEST(ScanNet, ParsersRefuseWhatIsWrong) {
  expect_refusal([] { parse_scannet_segments("{}", "s"); }, {"s: ", "segIndices"});
  expect_refusal([] { parse_scannet_segments(R"({"segIndices":[1,-2]})", "s"); },
                 {"segIndices[1]", "-2"});
  expect_refusal([] { parse_scannet_segments(R"({"segIndices":[1,[2]]})", "s"); }, {"an array"});
  expect_refusal([] { parse_scannet_segments(R"({"segIndices":[1,2.5]})", "s"); }, {"2.5"});
  expect_refusal([] { parse_scannet_segments(R"({"segIndices":[1,)", "s"); }, {"JSON"});
  expect_refusal([] { parse_scannet_segments(R"({"segIndices":{"a":1}})", "s"); }, {"an object"});
  EXPECT_TRUE(parse_scannet_segments(R"({"a":[1,[2]],"segIndices":[]})", "s").empty());
  expect_refusal([] { parse_scannet_aggregation(R"({"segGroups":[{"label":"a"}]})", "a"); },
                 {"a: /segGroups/0", "objectId"});
  expect_refusal([] { parse_scannet_alignment("axisAlignment = 1 2 3\n", "t"); },
                 {"t:1", "16 numbers", "3"});
  expect_refusal(
      [] { parse_scannet_alignment("axisAlignment = 2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n", "t"); },
      {"rigid"});
  EXPECT_TRUE(parse_scannet_alignment("sceneType = x\n", "t").isIdentity());
  expect_refusal([] { parse_scannet_label_map("raw_category\tcategory\n", "m"); }, {"nyu40id"});
  expect_refusal([] { parse_scannet_label_map("raw_category\tnyu40id\nchair\t41\n", "m"); },
                 {"m:2", "41"});
  expect_refusal([] { parse_scannet_label_map("", "m"); }, {"empty"});
}

TEST(ScanNet, VotenetFilesOfTheSampleAgreeWithTheirInstances) {
  ARBOX_REQUIRE_DATA(root, "scannet");
  const auto dataset = io::open_dataset(root);
  EXPECT_EQ(dataset->layout(), "scannet-votenet");
  EXPECT_EQ(dataset->names("train").size(), 1201u);
  EXPECT_EQ(dataset->names("val").size(), 312u);
  EXPECT_EQ(dataset->names("all"), std::vector<std::string>{"scene0000_00"});
  const auto scene = dataset->load("train", "scene0000_00");
  EXPECT_EQ(scene.cloud.size(), 50000u);
  ASSERT_EQ(scene.objects.size(), 27u);
  EXPECT_EQ(scene.objects[0].label, "window");
  for (std::size_t c = 3; c < 6; ++c) EXPECT_LE(scene.cloud.values[c], 1.0F);
  std::vector<int> points(scene.objects.size());
  for (std::size_t i = 0; i < scene.point_objects.size(); ++i) {
    if (scene.point_objects[i] < 0) continue;
    const auto& object = scene.objects[scene.point_objects[i]];
    ++points[scene.point_objects[i]];
    EXPECT_TRUE(
        geometry::contains(object.box, scene.cloud.view().position(i).cast<double>(), 1e-5));
  }
  for (const int count : points) EXPECT_GT(count, 10);
}

TEST(ScanNet, RawReleaseGivesTheBoxesOfTheNpyFiles) {
  ARBOX_REQUIRE_DATA(root, "scannet");
  const TemporaryDirectory folder;
  const auto full = root / "scannet_train_detection_data_full";
  RawScan scan{.name = "scene0000_00"};
  scan.instances = io::read_npy(full / "scene0000_00_ins_label_all.npy").values<std::uint32_t>();
  const auto nyu40 = io::read_npy(full / "scene0000_00_sem_label_all.npy").values<std::int32_t>();
  for (std::size_t i = 0; i < nyu40.size(); ++i) {
    if (scan.instances[i] > 0) {
      scan.labels.emplace(scan.instances[i], "raw " + std::to_string(nyu40[i]));
    }
  }
  // The release's mesh, of which points/*.bin are the vertices in order.
  scan.cloud.channels = {"r", "g", "b"};
  const std::string bytes = io::read_file(root / "points/scene0000_00.bin");
  scan.cloud.values.resize(bytes.size() / sizeof(float));
  std::memcpy(scan.cloud.values.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < scan.cloud.values.size(); ++i) {
    if (i % 6 >= 3) scan.cloud.values[i] /= 255.0F;
  }
  const auto boxes = nlohmann::json::parse(io::read_file(root / "scannet_gt_boxes_train.json"));
  const auto& entry = boxes.at("scenes").at("scene0000_00");
  for (const auto& row : entry.at("axis_align_matrix")) {
    for (const auto& number : row) scan.alignment += number.dump() + " ";
  }
  testing::write_raw_scan(folder, scan);
  folder.write("scannetv2-labels.combined.tsv", testing::made_label_map());
  const auto raw = io::open_dataset(folder.path())->load("all", "scene0000_00");
  const auto prepared = io::open_dataset(root)->load("train", "scene0000_00");
  EXPECT_EQ(raw.cloud.size(), 81369u);
  ASSERT_EQ(raw.objects.size(), prepared.objects.size());
  for (const auto& object : prepared.objects) {
    const auto same = std::find_if(raw.objects.begin(), raw.objects.end(), [&](const auto& other) {
      return (other.box.center - object.box.center).norm() < 1e-5 &&
             (other.box.size - object.box.size).norm() < 1e-5;
    });
    ASSERT_NE(same, raw.objects.end()) << object.box.center.transpose();
    EXPECT_EQ(same->label, object.label);
  }
}

}  // namespace
}  // namespace arbox
