#include "arbox/io/dataset.h"

#include <gtest/gtest.h>

#include "arbox/base/random.h"
#include "arbox/geometry/rotation.h"
#include "arbox/io/arbox_dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_dataset.h"
#include "io/expect_refusal.h"
#include "io/made_kitti.h"
#include "io/made_scene.h"

namespace arbox {
namespace {

using testing::expect_refusal;
using testing::made_scene;
using testing::TemporaryDirectory;

TEST(Dataset, GuessesNoLayoutOfWhatIsNone) {
  const TemporaryDirectory folder;
  expect_refusal([&] { io::open_dataset(folder.path()); },
                 {"looks like no dataset", "kitti: training/", "arbox: dataset.json"});
  expect_refusal([&] { io::open_dataset(folder / "none"); }, {"no such folder"});
  expect_refusal([&] { io::open_dataset(folder.write("a.txt", "")); }, {"a file"});
  expect_refusal([&] { io::open_dataset(folder.path(), {.layout = "kiti"}); }, {"kitti"});
  expect_refusal([&] { io::create_dataset(folder.path(), "kitti"); }, {"new or empty"});
  expect_refusal([&] { io::create_dataset(folder / "new", "labelclod"); }, {"kitti", "labelcloud"});
}

TEST(Dataset, KittiBehindTheInterfaceIsKitti) {
  const TemporaryDirectory folder;
  testing::make_kitti(folder);
  const auto dataset = io::open_dataset(folder.path());
  EXPECT_EQ(dataset->layout(), "kitti");
  EXPECT_EQ(dataset->splits(), (std::vector<std::string>{"train", "val", "training"}));
  const auto scene = dataset->load("train", "000001");
  ASSERT_EQ(scene.objects.size(), 2u);  // DontCare has no box.
  EXPECT_EQ(scene.objects[0].label, "Car");
  EXPECT_EQ(scene.objects[1].attributes.at("occlusion"), 2.0);
  ASSERT_TRUE(scene.photo);
  EXPECT_EQ(scene.photo->size, (io::ImageSize{1242, 375}));
  expect_refusal([&] { dataset->names("trian"); }, {"trian", "train, val"});
}

TEST(Dataset, OwnFolderIsReadWithClassMapAndSplits) {
  const TemporaryDirectory folder;
  folder.write("points/b.csv", "x,y,z,intensity\n1,2,3,0.5\n4,5,6,1\n");
  folder.write("points/a.bin", testing::kMadeScan);
  folder.write("points/c.xyz", "1 2 3\n");
  folder.write("labels/a.txt", "1 2 3 1 1 1 0.1 car\n0 0 0 1 1 1 0 junk\n");
  folder.write("labels/b.json", R"({"objects": []})");
  folder.write("labels/z.txt", "");
  folder.write("splits/train.txt", "a\nb\nq\n");
  folder.write("dataset.json", R"({"format": "arbox dataset", "version": 1, "classes": ["Car"],
      "class_map": {"car": "Car", "junk": null}})");
  const auto dataset = io::open_dataset(folder.path());
  EXPECT_EQ(dataset->layout(), "arbox");
  EXPECT_EQ(dataset->splits(), (std::vector<std::string>{"train", "all"}));
  EXPECT_EQ(dataset->names("all"), (std::vector<std::string>{"a", "b", "c"}));
  ASSERT_EQ(dataset->problems().size(), 2u);
  EXPECT_NE(dataset->problems()[0].find("'q'"), std::string::npos);
  EXPECT_NE(dataset->problems()[1].find("z.txt: labels without a cloud"), std::string::npos);
  const auto a = dataset->load("train", "a");
  ASSERT_EQ(a.objects.size(), 1u);
  EXPECT_EQ(a.objects[0].label, "Car");
  EXPECT_EQ(a.cloud.channels, std::vector<std::string>{"intensity"});
  EXPECT_TRUE(dataset->load("all", "b").labelled);
  EXPECT_FALSE(dataset->load("all", "c").labelled);
  folder.write("labels/b.json", R"({"objects": [{"class": "Van", "box": {"center": [0,0,0],
      "size": [1,1,1], "yaw": 0}}]})");
  expect_refusal([&] { dataset->load("all", "b"); }, {"b.json", "'Van'", "class_map"});
  folder.write("labels/b.json", R"({"frame": "camera", "objects": []})");
  expect_refusal([&] { dataset->load("all", "b"); }, {"frame lidar", "frame camera"});
}

TEST(Dataset, InitMakesTheFolderAndReadsWhatIsThere) {
  const TemporaryDirectory folder;
  const auto root = folder / "new";
  auto report = io::init_dataset(root, {.frame = io::SceneFrame::kRoom});
  EXPECT_EQ(report.scans, 0u);
  EXPECT_EQ(report.notes.size(), 2u);
  EXPECT_EQ(io::open_dataset(root)->frame(), io::SceneFrame::kRoom);
  for (int i = 0; i < 10; ++i) {
    folder.write("new/points/s" + std::to_string(i) + ".csv", "1,2,3\n");
    folder.write(
        "new/labels/s" + std::to_string(i) + ".txt",
        i % 2 == 0 ? "0 0 0 1 1 1 0 rare\n0 0 0 1 1 1 0 often\n" : "0 0 0 1 1 1 0 often\n");
  }
  std::filesystem::remove(root / "dataset.json");
  report = io::init_dataset(root, {});
  EXPECT_EQ(report.classes, (std::vector<std::string>{"often", "rare"}));
  EXPECT_TRUE(report.notes.empty());
  const auto dataset = io::open_dataset(root);
  EXPECT_EQ(dataset->classes(), report.classes);
  EXPECT_EQ(dataset->names("val"), (std::vector<std::string>{"s4", "s9"}));
  EXPECT_EQ(dataset->names("train").size(), 8u);
  const std::string before = io::read_file(root / "dataset.json");
  EXPECT_TRUE(io::init_dataset(root, {.classes = {"x"}}).made.empty());
  EXPECT_EQ(io::read_file(root / "dataset.json"), before);
}

TEST(Dataset, FramesTurnThereAndBack) {
  for (const auto frame :
       {io::SceneFrame::kLidar, io::SceneFrame::kRoom, io::SceneFrame::kCamera}) {
    const auto scene = made_scene("a", 7, frame, {"x"}, testing::MadeBoxes::kAny);
    for (const auto other :
         {io::SceneFrame::kLidar, io::SceneFrame::kRoom, io::SceneFrame::kCamera}) {
      const auto turned = io::converted(scene, other);
      EXPECT_EQ(turned.frame, other);
      const auto inside = io::points_in_boxes(turned.cloud.view(), {turned.objects[0].box}, 1e-4);
      EXPECT_EQ(inside, io::points_in_boxes(scene.cloud.view(), {scene.objects[0].box}, 1e-4));
      testing::expect_same_objects(io::converted(turned, frame), scene, 1e-9);
    }
  }
  auto lidar = made_scene("a", 7, io::SceneFrame::kLidar, {"x"}, testing::MadeBoxes::kAny);
  lidar.cloud.values = {1, 2, 3};
  lidar.cloud.channels.clear();
  EXPECT_EQ(io::converted(lidar, io::SceneFrame::kCamera).cloud.values,
            (std::vector<float>{-2, -3, 1}));
  EXPECT_EQ(io::converted(lidar, io::SceneFrame::kRoom).cloud.values,
            (std::vector<float>{-2, 1, 3}));
}

TEST(Dataset, WritersFitWhatALayoutCannotHold) {
  const TemporaryDirectory folder;
  auto scene =
      made_scene("a", 3, io::SceneFrame::kRoom, {"chair", "unicorn"}, testing::MadeBoxes::kAny);
  const auto writer = io::create_dataset(folder / "out", "scannet-votenet");
  writer->add("train", scene);
  const auto report = writer->finish();
  EXPECT_EQ(report.left_out.at("unicorn") + report.objects, scene.objects.size());
  EXPECT_EQ(report.enclosed, report.objects);
  const auto read = io::open_dataset(folder / "out")->load("train", "a");
  ASSERT_EQ(read.objects.size(), report.objects);
  std::size_t next = 0;
  for (const auto& object : scene.objects) {
    if (object.label != "chair") continue;
    const auto hull = geometry::axis_aligned_hull(object.box);
    EXPECT_TRUE(read.objects[next++].box.size.isApprox(hull.sizes(), 1e-9));
  }
}

}  // namespace
}  // namespace arbox
