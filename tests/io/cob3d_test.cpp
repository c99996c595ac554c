#include "arbox/io/cob3d.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "arbox/geometry/rotation.h"
#include "arbox/io/dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/npz.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace arbox {
namespace {

using testing::expect_refusal;
using testing::TemporaryDirectory;

/// Two flat objects before a wall, 6 x 4 pixels.
io::LabeledScene made_bin() {
  io::LabeledScene scene{.name = "00000", .frame = io::SceneFrame::kCamera};
  io::RgbdImages& images = scene.images.emplace();
  images.width = 6;
  images.height = 4;
  images.intrinsic << 10, 0, 2.5, 0, 10, 1.5, 0, 0, 1;
  images.depth.assign(24, 1.25F);
  images.depth[0] = 0.0F;
  for (int i = 0; i < 24; ++i) {
    images.rgb.insert(images.rgb.end(), {static_cast<std::uint8_t>(10 * i), 0, 255});
    images.normals.insert(images.normals.end(), {0, 0, -1});
  }
  std::vector<std::uint8_t> first(24), second(24);
  first[8] = first[9] = 1;
  second[14] = second[15] = second[9] = 1;
  images.amodal_masks = {first, second};
  second[9] = 0;
  images.visible_masks = {first, second};
  scene.objects = {{.label = "object",
                    .box = {.center = {0.1, 0, 1.3},
                            .size = {0.2, 0.1, 0.05},
                            .rotation = geometry::to_quaternion(geometry::ZyzAngles{1, 0.5, 2})},
                    .heading = io::Heading::kUnknown},
                   {.label = "object",
                    .box = {.center = {-0.1, 0.1, 1.2}, .size = {0.1, 0.2, 0.3}},
                    .heading = io::Heading::kUnknown}};
  return scene;
}

/// Writes the made bin and reads it from the split and from all scenes.
std::vector<io::LabeledScene> written_and_read(const TemporaryDirectory& folder,
                                               const std::string& layout,
                                               const std::string& name_in_all) {
  const auto writer = io::create_dataset(folder / layout, layout, io::SceneFrame::kCamera);
  writer->add("train", made_bin());
  writer->finish();
  const auto dataset = io::open_dataset(folder / layout);
  EXPECT_EQ(dataset->layout(), layout);
  EXPECT_EQ(dataset->names("train"), std::vector<std::string>{"00000"});
  EXPECT_EQ(dataset->names("all"), std::vector<std::string>{name_in_all});
  return {dataset->load("train", "00000"), dataset->load("all", name_in_all)};
}

TEST(Cob3d, WrittenScenesComeBack) {
  const TemporaryDirectory folder;
  const auto made = made_bin();
  auto scenes = written_and_read(folder, "cob3d", "train/00000");
  for (auto& scene : written_and_read(folder, "cob3d-v2", "00000")) {
    scenes.push_back(std::move(scene));
  }
  for (const auto& scene : scenes) {
    EXPECT_EQ(scene.images->depth, made.images->depth);
    EXPECT_EQ(scene.images->rgb, made.images->rgb);
    EXPECT_EQ(scene.images->normals, made.images->normals);
    EXPECT_EQ(scene.images->intrinsic, made.images->intrinsic);
    EXPECT_EQ(scene.images->visible_masks, made.images->visible_masks);
    EXPECT_EQ(scene.images->amodal_masks, made.images->amodal_masks);
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_LE((scene.objects[0].box.size - made.objects[0].box.size).norm(), 1e-12);
    EXPECT_LE((scene.objects[0].box.center - made.objects[0].box.center).norm(), 1e-12);
    EXPECT_LE(
        geometry::rotation_distance(scene.objects[0].box.rotation, made.objects[0].box.rotation),
        1e-7);
    ASSERT_EQ(scene.cloud.size(), 23u);  // One pixel was not measured.
    // Pixel 8 is (2, 1).
    EXPECT_LE(
        (scene.cloud.view().position(7) - Eigen::Vector3f(-0.05F * 1.25F, -0.05F * 1.25F, 1.25F))
            .norm(),
        1e-6F);
    EXPECT_EQ(scene.point_objects[7], 0);
    EXPECT_EQ(scene.point_objects[13], 1);
    EXPECT_EQ(std::count(scene.point_objects.begin(), scene.point_objects.end(), -1), 19);
  }
}

TEST(Cob3d, VersionsBecomeEachOtherAndClouds) {
  const TemporaryDirectory folder;
  const auto first = written_and_read(folder, "cob3d", "train/00000")[0];
  for (const char* layout : {"cob3d-v2", "arbox", "labelcloud", "cvat", "kitti"}) {
    const auto root = folder / (std::string("from_v1_") + layout);
    const auto writer = io::create_dataset(root, layout, io::SceneFrame::kCamera, {"object"});
    writer->add("train", first);
    EXPECT_EQ(writer->finish().enclosed, layout == std::string("kitti") ? 1u : 0u) << layout;
    const auto dataset = io::open_dataset(root);
    const auto scene = dataset->load(dataset->splits().back(), "00000");
    EXPECT_EQ(scene.objects.size(), 2u) << layout;
    EXPECT_EQ(scene.cloud.size(), 23u) << layout;
  }
  const auto second = io::open_dataset(folder / "from_v1_cob3d-v2")->load("train", "00000");
  EXPECT_EQ(second.images->amodal_masks, first.images->amodal_masks);
  io::write_cob3d_scene(folder / "again", second);
  EXPECT_EQ(io::read_cob3d_scene(folder / "again").images->rgb, first.images->rgb);
}

TEST(Cob3d, ScenesWithoutLabelsStayWithout) {
  const TemporaryDirectory folder;
  auto scene = made_bin();
  scene.objects.clear();
  scene.labelled = false;
  scene.images->visible_masks.clear(), scene.images->amodal_masks.clear();
  io::write_cob3d_scene(folder / "a", scene);
  io::write_cob3d_v2_scene(folder / "a.npz", scene);
  EXPECT_FALSE(io::read_cob3d_scene(folder / "a").labelled);
  EXPECT_FALSE(io::read_cob3d_v2_scene(folder / "a.npz").labelled);
}

TEST(Cob3d, PythonReadsVersionTwo) {
  const TemporaryDirectory folder;
  io::write_cob3d_v2_scene(folder / "a.npz", made_bin());
  const auto read = testing::run("/usr/bin/python3", {"-c", R"(
import sys, numpy as np
d = np.load(sys.argv[1], allow_pickle=True)
poses, grid, segm = d['obj_poses'].item(), d['voxel_grid'].item(), d['segm'].item()
assert d['rgb'].shape == (3, 4, 6) and d['depth_map'].shape == (4, 6) and d['intrinsic'].shape == (3, 3)
assert segm['masks'].shape == segm['amodal_masks'].shape == (2, 4, 6) and segm['masks'].dtype == bool
assert segm['boxes'].tolist() == [[2, 1, 3, 1], [2, 1, 3, 2]], segm['boxes']
half = np.linalg.norm(poses['poses'][:, :3, :3], axis=1) * grid['extents'] / poses['scales']
assert np.allclose(2 * half, [[0.2, 0.1, 0.05], [0.1, 0.2, 0.3]])
assert np.allclose(poses['poses'][:, :3, 3], [[0.1, 0, 1.3], [-0.1, 0.1, 1.2]])
assert float(d['near_plane']) == float(d['far_plane']) == 1.25
)",
                                                      (folder / "a.npz").string()});
  EXPECT_EQ(read.exit_code, 0) << read.errors;
}

TEST(Cob3d, OtherNumberTypesAndOrdersAreRead) {
  const TemporaryDirectory folder;
  // Colours in 0..255, masks as floats, a pixel without depth.
  std::vector<float> rgb(3 * 6, 128.0F), depth = {1, 2, 3, 4, NAN, -1}, masks(6, 0.0F);
  masks[1] = 1.0F;
  const std::vector<double> identity = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  folder.write("train/00000/data.npz",
               io::encode_npz({{"rgb", io::encode_npy<float>(rgb, {3, 2, 3})},
                               {"depth", io::encode_npy<float>(depth, {2, 3})},
                               {"intrinsic", io::encode_npy<double>(identity, {3, 3})}}));
  auto scene = io::read_cob3d_scene(folder / "train/00000");
  EXPECT_FALSE(scene.labelled);
  EXPECT_EQ(scene.cloud.size(), 4u);
  EXPECT_EQ(scene.images->rgb[0], 128);
  EXPECT_EQ(scene.images->depth[4], 0.0F);
  folder.write("train/00000/annotation/segm.npz",
               io::encode_npz({{"masks", io::encode_npy<float>(masks, {1, 2, 3})},
                               {"masks_amodal", io::encode_npy<float>(masks, {1, 2, 3})}}));
  EXPECT_EQ(io::read_cob3d_scene(folder / "train/00000").point_objects[1], 0);
}

TEST(Cob3d, RefusesWhatDoesNotFit) {
  const TemporaryDirectory folder;
  io::write_cob3d_scene(folder / "a", made_bin());
  const std::vector<double> rows = {1, 1, 1}, bad = {2, 0, 0, 0};
  const auto boxes = [&](std::span<const double> sizes, std::span<const double> turns) {
    return io::encode_npz({{"dimensions", io::encode_npy<double>(sizes, {sizes.size() / 3, 3})},
                           {"centers", io::encode_npy<double>(rows, {1, 3})},
                           {"orientations", io::encode_npy<double>(turns, {turns.size() / 4, 4})}});
  };
  folder.write("a/annotation/bbox3d.npz", boxes(rows, bad));
  expect_refusal([&] { io::read_cob3d_scene(folder / "a"); }, {"object 0", "unit quaternion"});
  const std::vector<double> good = {1, 0, 0, 0};
  folder.write("a/annotation/bbox3d.npz", boxes(rows, good));
  expect_refusal([&] { io::read_cob3d_scene(folder / "a"); }, {"one mask an object (1)", "2"});
  folder.write("a/data.npz", "PK");
  expect_refusal([&] { io::read_cob3d_scene(folder / "a"); }, {"data.npz"});
  auto scene = made_bin();
  scene.images->amodal_masks.pop_back();
  expect_refusal([&] { io::write_cob3d_scene(folder / "b", scene); }, {"one mask"});
  scene.images.reset();
  expect_refusal([&] { io::write_cob3d_scene(folder / "b", scene); }, {"depth images"});
}

constexpr const char* kMakeV2 = R"(
import sys, numpy as np
mask = np.zeros((2, 4, 6), bool); mask[0, 1, 2] = True; mask[1, 2, 3] = True
pose = np.tile(np.eye(4), (2, 1, 1))
c, s = np.cos(0.3), np.sin(0.3)
pose[0, :3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) * 2.0
pose[0, :3, 3] = [0.1, 0.2, 1.0]
np.savez(sys.argv[1], rgb=np.full((3, 4, 6), 0.5, np.float32),
         depth_map=np.full((4, 6), 1.5), intrinsic=np.diag([10.0, 10, 1]),
         near_plane=0.5, far_plane=2.0, mesh_ids=np.array(['a', 'b']),
         segm=dict(boxes=np.zeros((2, 4)), masks=mask, amodal_masks=mask),
         obj_poses=dict(poses=pose, scales=np.array([[1.0, 2.0, 4.0], [1, 1, 1]])),
         voxel_grid=dict(voxels=np.zeros((2, 2, 2, 2), bool), extents=np.array([[0.1, 0.2, 0.4], [1, 2, 3]])))
)";

TEST(Cob3d, VersionTwoIsReadWithoutRunningItsPickles) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "scenes");
  const std::string id = "0a1b2c3d-0000-4000-8000-000000000001";
  const auto made = testing::run("/usr/bin/python3",
                                 {"-c", kMakeV2, (folder / ("scenes/" + id + ".npz")).string()});
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  folder.write("dset.json", R"({"val": [")" + id + R"("], "train": []})");
  const auto dataset = io::open_dataset(folder.path());
  EXPECT_EQ(dataset->layout(), "cob3d-v2");
  EXPECT_EQ(dataset->splits(), (std::vector<std::string>{"val", "train", "all"}));
  const auto scene = dataset->load("val", id);
  ASSERT_EQ(scene.objects.size(), 2u);
  // Half axes: columns of the pose (here of length 2) times extents over scales (0.1 each).
  EXPECT_TRUE(scene.objects[0].box.size.isApprox(Eigen::Vector3d(0.4, 0.4, 0.4), 1e-12));
  EXPECT_NEAR(geometry::yaw(scene.objects[0].box), 0.3, 1e-12);
  EXPECT_TRUE(scene.objects[0].box.center.isApprox(Eigen::Vector3d(0.1, 0.2, 1.0)));
  EXPECT_EQ(scene.objects[1].box.size, Eigen::Vector3d(2, 4, 6));
  EXPECT_EQ(scene.images->visible_masks[1][15], 1);
  EXPECT_EQ(scene.cloud.size(), 24u);
  EXPECT_EQ(scene.images->rgb[0], 128);
}

}  // namespace
}  // namespace arbox
