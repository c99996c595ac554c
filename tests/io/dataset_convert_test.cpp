// Every layout written and read back, and every layout made of every other one.
#include <gtest/gtest.h>

#include "arbox/io/dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/sunrgbd.h"
#include "io/expect_refusal.h"
#include "io/made_scene.h"
#include "support/program.h"

namespace arbox {
namespace {

using io::SceneFrame;
using testing::expect_refusal;
using testing::made_scene;
using testing::MadeBoxes;
using testing::TemporaryDirectory;

struct LayoutCase {
  std::string layout;
  SceneFrame frame = SceneFrame::kRoom;
  std::vector<std::string> classes = {"chair", "bed"};
  MadeBoxes boxes = MadeBoxes::kAny;
  double tolerance = 1e-12;
  std::string infos = "1.1";
  /// False where the layout has no place for splits.
  bool splits = true;
};

std::vector<LayoutCase> layout_cases() {
  using enum MadeBoxes;
  return {{.layout = "arbox", .frame = SceneFrame::kLidar, .classes = {"Car", "Dog"}},
          {.layout = "arbox"},
          {.layout = "kitti", .frame = SceneFrame::kLidar, .boxes = kUpright, .tolerance = 3e-4},
          {.layout = "scannet", .boxes = kAxisAligned, .tolerance = 1e-6},
          {.layout = "scannet-votenet", .boxes = kAxisAligned},
          {.layout = "scannet-mmdet3d", .boxes = kAxisAligned},
          {.layout = "scannet-mmdet3d", .boxes = kAxisAligned, .infos = "1.0"},
          {.layout = "scannet-mmdet3d", .boxes = kAxisAligned, .infos = "0.x"},
          {.layout = "sunrgbd", .classes = {"chair", "lamp"}, .boxes = kUpright, .tolerance = 1e-8},
          {.layout = "sunrgbd-votenet", .boxes = kUpright},
          {.layout = "sunrgbd-mmdet3d", .boxes = kUpright},
          {.layout = "sunrgbd-mmdet3d", .boxes = kUpright, .infos = "1.0"},
          {.layout = "sunrgbd-mmdet3d", .boxes = kUpright, .infos = "0.x"},
          {.layout = "sunrgbd-toolbox", .classes = {"chair", "floor lamp"}, .boxes = kUpright},
          {.layout = "labelcloud", .frame = SceneFrame::kLidar, .tolerance = 1e-9, .splits = false},
          {.layout = "cvat",
           .frame = SceneFrame::kLidar,
           .classes = {"a <b> & c", "Car"},
           .tolerance = 1e-9,
           .splits = false}};
}

std::string case_name(const LayoutCase& one) {
  std::string name = one.layout + std::string(io::name_of(one.frame)) + one.infos;
  std::erase_if(name, [](unsigned char letter) { return std::isalnum(letter) == 0; });
  return name;
}

/// In layouts of hulls boxes end where their points do.
void shrink_to_points(io::LabeledScene& scene) {
  const auto view = scene.cloud.view();
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    Eigen::AlignedBox3f hull;
    for (std::size_t i = 0; i < view.size(); ++i) {
      if (scene.point_objects[i] == static_cast<std::int32_t>(o)) hull.extend(view.position(i));
    }
    scene.objects[o].box.center = ((hull.min() + hull.max()) / 2.0F).cast<double>();
    scene.objects[o].box.size = hull.sizes().cast<double>();
  }
}

/// Three scenes, the last one without objects.
std::vector<io::LabeledScene> made_scenes(const LayoutCase& layout) {
  std::vector<io::LabeledScene> scenes;
  for (int i = 0; i < 3; ++i) {
    auto scene = made_scene("00000" + std::to_string(i + 1), 10 + i, layout.frame, layout.classes,
                            layout.boxes);
    if (layout.layout == "scannet") shrink_to_points(scene);
    if (i == 2) scene.objects.clear(), scene.point_objects.clear();
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

class RoundTripTest : public ::testing::TestWithParam<LayoutCase> {};

TEST_P(RoundTripTest, ScenesComeBackAsTheyWent) {
  const LayoutCase& layout = GetParam();
  const TemporaryDirectory folder;
  const auto writer = io::create_dataset(folder / "out", layout.layout, layout.frame,
                                         layout.classes, {.infos = layout.infos});
  const auto scenes = made_scenes(layout);
  writer->add("train", scenes[0]);
  writer->add("val", scenes[1]);
  writer->add("train", scenes[2]);
  expect_refusal([&] { writer->add("val", scenes[0]); }, {"000001", "second time"});
  const auto report = writer->finish();
  EXPECT_EQ(report.scenes, 3u);
  EXPECT_TRUE(report.left_out.empty());
  EXPECT_TRUE(report.notes.empty()) << report.notes.begin()->first;
  EXPECT_EQ(report.enclosed, 0u);
  const auto dataset = io::open_dataset(folder / "out", {.classes = "all"});
  EXPECT_EQ(dataset->layout(), layout.layout);
  EXPECT_TRUE(dataset->problems().empty());
  EXPECT_EQ(dataset->names(dataset->splits().back()).size(), 3u);
  if (layout.splits) {
    EXPECT_EQ(dataset->names("train"), (std::vector<std::string>{"000001", "000003"}));
    EXPECT_EQ(dataset->names("val"), std::vector<std::string>{"000002"});
  }
  for (const auto& scene : scenes) {
    const auto read = dataset->load(dataset->splits().back(), scene.name);
    EXPECT_TRUE(read.labelled);
    testing::expect_same_objects(read, scene, layout.tolerance);
    testing::expect_same_cloud(read, scene);
    if (!read.point_objects.empty() && !scene.objects.empty()) {
      EXPECT_EQ(read.point_objects, scene.point_objects);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Layouts, RoundTripTest, ::testing::ValuesIn(layout_cases()),
                         [](const auto& entry) { return case_name(entry.param); });

/// Writes all scenes of a dataset in another layout.
io::WriteReport convert(const std::filesystem::path& from, const std::filesystem::path& to,
                        const LayoutCase& layout) {
  const auto dataset = io::open_dataset(from, {.classes = "all"});
  const auto writer = io::create_dataset(to, layout.layout, dataset->frame(), dataset->classes(),
                                         {.infos = layout.infos});
  const auto splits = dataset->splits();
  for (const std::string& name : dataset->names(splits.back())) {
    writer->add("train", dataset->load(splits.back(), name));
  }
  return writer->finish();
}

TEST(Convert, EveryLayoutBecomesEveryOther) {
  const TemporaryDirectory folder;
  for (LayoutCase from : layout_cases()) {
    from.classes = {"chair", "bed"};
    const auto source = folder / ("from" + case_name(from));
    const auto writer =
        io::create_dataset(source, from.layout, from.frame, from.classes, {.infos = from.infos});
    const auto scenes = made_scenes(from);
    for (const auto& scene : scenes) writer->add("train", scene);
    writer->finish();
    for (const LayoutCase& to : layout_cases()) {
      SCOPED_TRACE(case_name(from) + " to " + case_name(to));
      const auto target = folder / (case_name(from) + case_name(to));
      const auto report = convert(source, target, to);
      EXPECT_EQ(report.scenes, 3u);
      EXPECT_EQ(report.objects, 12u);
      EXPECT_TRUE(report.left_out.empty());
      const auto dataset = io::open_dataset(target, {.classes = "all"});
      const auto names = dataset->names(dataset->splits().back());
      ASSERT_EQ(names.size(), 3u);
      const auto read =
          io::converted(dataset->load(dataset->splits().back(), names[0]), SceneFrame::kRoom);
      // What the source could not hold is not asked of the target.
      const auto given = io::open_dataset(source, {.classes = "all"});
      const auto expected =
          io::converted(given->load(given->splits().back(), scenes[0].name), SceneFrame::kRoom);
      testing::expect_same_cloud(read, expected);
      ASSERT_EQ(read.objects.size(), 6u);
      for (std::size_t i = 0; i < 6; ++i) {
        const auto& box = expected.objects[i].box;
        EXPECT_EQ(read.objects[i].label, expected.objects[i].label);
        // The hulls of 40 points are smaller than their boxes, the rest encloses them.
        EXPECT_LE((read.objects[i].box.center - box.center).norm(), 0.5);
        if (to.layout == "scannet") continue;
        EXPECT_GE(geometry::volume(read.objects[i].box), geometry::volume(box) * (1 - 3e-3));
        for (const auto& corner : geometry::corners(box)) {
          EXPECT_TRUE(geometry::contains(read.objects[i].box, corner, 2e-3));
        }
      }
      std::filesystem::remove_all(target);
    }
  }
}

TEST(Convert, CloudsAreNoDepthImages) {
  const TemporaryDirectory folder;
  const auto scene = made_scene("a", 3, SceneFrame::kRoom, {"chair"}, MadeBoxes::kAny);
  for (const char* layout : {"cob3d", "cob3d-v2"}) {
    const auto writer = io::create_dataset(folder / layout, layout, SceneFrame::kRoom);
    expect_refusal([&] { writer->add("train", scene); }, {"scene a", "depth images, no clouds"});
  }
}

TEST(Convert, WhatALayoutCannotHoldIsTold) {
  const TemporaryDirectory folder;
  auto scene = made_scene("a", 3, SceneFrame::kRoom, {"chair"}, MadeBoxes::kAxisAligned);
  const auto notes = [&](const std::string& layout, const std::string& split) {
    const auto root = folder / (layout + split + (scene.labelled ? "" : "u"));
    const auto writer = io::create_dataset(root, layout, SceneFrame::kRoom);
    writer->add(split, scene);
    return writer->finish().notes;
  };
  EXPECT_EQ(notes("scannet", "train").size(), 1u);  // Hulls in place of boxes.
  EXPECT_EQ(notes("kitti", "test").size(), 1u);     // Labels of the testing folder.
  EXPECT_EQ(notes("kitti", "train").size(), 0u);
  const auto test = io::open_dataset(folder / "kittitest")->load("test", "a");
  EXPECT_FALSE(test.labelled);
  EXPECT_EQ(test.cloud.size(), scene.cloud.size());
  EXPECT_EQ(notes("sunrgbd-toolbox", "train").size(), 1u);  // A number for a name.
  EXPECT_EQ(io::open_dataset(folder / "sunrgbd-toolboxtrain")->names("train"),
            std::vector<std::string>{"000001"});
  scene.labelled = false;
  scene.objects.clear(), scene.point_objects.clear();
  for (const char* layout : {"arbox", "scannet", "scannet-votenet", "scannet-mmdet3d", "sunrgbd",
                             "sunrgbd-votenet", "sunrgbd-mmdet3d", "labelcloud"}) {
    EXPECT_TRUE(notes(layout, "train").empty()) << layout;
    const auto dataset = io::open_dataset(folder / (std::string(layout) + "trainu"));
    EXPECT_FALSE(dataset->load(dataset->splits().back(), "a").labelled) << layout;
  }
  for (const char* layout : {"kitti", "cvat"}) {
    EXPECT_EQ(notes(layout, "train").count("scans without labels became scans with no objects"), 1u)
        << layout;
  }
}

TEST(Convert, ToolboxKeepsNumbersAndGaps) {
  const TemporaryDirectory folder;
  const auto writer = io::create_dataset(folder / "out", "sunrgbd-toolbox");
  for (const char* name : {"000007", "000002"}) {
    writer->add("val", made_scene(name, 3, SceneFrame::kRoom, {"chair"}, MadeBoxes::kUpright));
  }
  EXPECT_TRUE(writer->finish().notes.empty());
  const auto dataset = io::open_dataset(folder / "out");
  EXPECT_EQ(dataset->names("all"), (std::vector<std::string>{"000002", "000007"}));
  EXPECT_EQ(dataset->load("val", "000007").objects.size(), 6u);
}

TEST(Convert, PhotosComeAlongWhereCamerasDo) {
  const TemporaryDirectory folder;
  auto scene = made_scene("000001", 3, SceneFrame::kRoom, {"chair"}, MadeBoxes::kUpright);
  io::SunRgbdCalibration calibration;
  calibration.tilt = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()).matrix();
  calibration.intrinsic << 529.5, 0, 365, 0, 530, 265, 0, 0, 1;
  scene.photo = io::ScenePhoto{.path = folder.write("p.png", "picture"),
                               .size = {},
                               .projection = io::projection_of(calibration)};
  for (auto& object : scene.objects) {
    object.attributes = {{"left", 1}, {"top", 2}, {"right", 30}, {"bottom", 40}};
  }
  for (const std::string infos : {"1.1", "1.0", "0.x"}) {
    for (const std::string layout : {"arbox", "sunrgbd", "sunrgbd-mmdet3d", "sunrgbd-toolbox"}) {
      const auto root = folder / (layout + infos);
      const auto writer = io::create_dataset(root, layout, SceneFrame::kRoom, {}, {.infos = infos});
      writer->add("train", scene);
      writer->finish();
      const auto read =
          io::open_dataset(root, {.yaw = infos == "0.x" ? "clockwise" : "counter-clockwise"})
              ->load("train", "000001");
      ASSERT_TRUE(read.photo) << layout;
      EXPECT_EQ(io::read_file(read.photo->path), "picture");
      EXPECT_TRUE(read.photo->projection.isApprox(scene.photo->projection, 1e-9)) << layout;
      if (layout == "arbox") continue;
      EXPECT_EQ(read.objects[0].attributes.at("right"), 30.0);
    }
  }
}

constexpr const char* kReadInfos = R"(
import pickle, sys, numpy as np
root, version = sys.argv[1], sys.argv[2]
infos = pickle.load(open(root + '/sunrgbd_infos_train.pkl', 'rb'))
if version == '1.1':
    assert infos['metainfo']['categories']['chair'] == 3
    info = infos['data_list'][0]
    points = np.fromfile(root + '/points/' + info['lidar_points']['lidar_path'], np.float32)
    assert points.size % info['lidar_points']['num_pts_feats'] == 0
    boxes = np.array([i['bbox_3d'] for i in info['instances']])
    assert all(type(x) is float for i in info['instances'] for x in i['bbox_3d'])
else:
    annos = infos[0]['annos']
    assert annos['gt_num'] == 6 and list(annos['name']) == ['chair'] * 6
    boxes = annos['gt_boxes_upright_depth']
    l, w, h = annos['dimensions'][0]
    assert np.allclose([l, h, w] if version == '0.x' else [l, w, h], boxes[0, 3:6])
    assert infos[1]['annos'] == {'gt_num': 0}
assert boxes.shape == (6, 7)
print(repr(float(boxes[0, 6])))
)";

TEST(Convert, PythonReadsTheInfosOfBothGenerations) {
  const auto scene = made_scene("000001", 3, SceneFrame::kRoom, {"chair"}, MadeBoxes::kUpright);
  auto empty = scene;
  empty.name = "000002";
  empty.objects.clear(), empty.point_objects.clear();
  for (const std::string infos : {"1.1", "1.0", "0.x"}) {
    const TemporaryDirectory folder;
    const auto writer = io::create_dataset(folder / "a", "sunrgbd-mmdet3d", SceneFrame::kRoom, {},
                                           {.infos = infos});
    writer->add("train", scene);
    writer->add("train", empty);
    writer->finish();
    const auto read =
        testing::run("/usr/bin/python3", {"-c", kReadInfos, (folder / "a").string(), infos});
    ASSERT_EQ(read.exit_code, 0) << infos << read.errors;
    const double sign = infos == "0.x" ? -1.0 : 1.0;
    EXPECT_NEAR(std::stod(read.output), sign * geometry::yaw(scene.objects[0].box), 1e-12);
  }
  const TemporaryDirectory folder;
  expect_refusal(
      [&] {
        io::create_dataset(folder / "b", "sunrgbd-mmdet3d", SceneFrame::kRoom, {},
                           {.infos = "2.0"});
      },
      {"infos", "2.0"});
}

}  // namespace
}  // namespace arbox
