#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/geometry/overlap.h"
#include "arbox/simulation/street_dataset.h"
#include "arbox/training/points_in_boxes.h"
#include "arbox/training/scene_data.h"
#include "arbox/training/scene_transform.h"
#include "support/program.h"

namespace arbox::training {
namespace {

using ::testing::HasSubstr;

const ClassNames kClasses({"Car", "Pedestrian", "Cyclist"});

TEST(ClassNames, SayWhatIsAnObjectAndWhatResemblesOne) {
  EXPECT_EQ(kClasses.object("Car").label, 0);
  EXPECT_EQ(kClasses.object("cyclist").label, 2);
  EXPECT_EQ(kClasses.object("Van").label, kOtherObject);
  EXPECT_EQ(kClasses.object("Van").resembles, 0);
  EXPECT_EQ(kClasses.object("Person_sitting").resembles, 1);
  EXPECT_EQ(kClasses.object("Tram").label, kOtherObject);
  EXPECT_EQ(kClasses.object("Tram").resembles, -1);
  EXPECT_EQ(ClassNames({"Car", "Van"}).object("Van").label, 1);
  EXPECT_THROW(ClassNames({}), ConfigError);
  EXPECT_THROW(ClassNames({"Car", "car"}), ConfigError);
}

TEST(SceneObjects, FewPointsLeaveOutAndUnseenOnesAreAsHardAsTheyHavePoints) {
  Scene scene;
  scene.cloud.channels = {"intensity"};
  for (int i = 0; i < 5; ++i) {
    SceneObject object;
    object.box = geometry::make_yaw_box({10.0 * i, 0, 0}, {2, 2, 2}, 0.4);
    object.difficulty = 1;
    scene.objects.push_back(object);
    const int points[] = {0, 4, 20, 80, 300};
    for (int k = 0; k < points[i]; ++k) {
      scene.cloud.values.insert(scene.cloud.values.end(), {10.0f * i + 0.001f * k, 0, 0, 0});
    }
  }
  finish_objects(scene, {true, true, true, true, false}, 4);
  ASSERT_EQ(scene.objects.size(), 4u);
  const int expected[] = {-1, 2, 1, 1};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(scene.objects[i].difficulty, expected[i]) << i;
}

/// Two simulated scans in a folder.
const std::filesystem::path& street_folder() {
  static const arbox::testing::TemporaryDirectory folder;
  static const bool written = [] {
    simulation::write_street_dataset({}, 21, 2, folder.path());
    return true;
  }();
  (void)written;
  return folder.path();
}

TEST(Sources, AFolderAndTheSimulatorGiveTheSameScene) {
  SceneDataOptions folder, street;
  folder.kitti.root = street_folder();
  folder.kitti.split = "trainval";
  folder.kitti.all_round = true;
  folder.kitti.min_points = 5;
  street.kind = "street";
  street.street.seed = 21;
  street.street.scenes = 2;
  const auto from_folder = make_scene_source(folder, kClasses.names());
  const auto from_street = make_scene_source(street, kClasses.names());
  ASSERT_EQ(from_folder->size(), 2);
  for (std::int64_t i = 0; i < 2; ++i) {
    const Scene one = from_folder->scene(i), other = from_street->scene(i);
    EXPECT_EQ(one.cloud.values, other.cloud.values);
    ASSERT_GT(one.objects.size(), 3u);
    for (const SceneObject& object : one.objects) {
      double best = 0;
      for (const SceneObject& same : other.objects) {
        if (same.label == object.label && same.resembles == object.resembles) {
          best = std::max(best, geometry::overlap(object.box, same.box));
        }
      }
      EXPECT_GT(best, 0.85) << "labels have two decimals and no tilt";
    }
    ASSERT_TRUE(one.ground && other.ground);
    EXPECT_NEAR(ground_height(*one.ground, 10, 2), ground_height(*other.ground, 10, 2), 1e-3);
    for (const std::int64_t points : count_points(one.cloud, one.objects)) EXPECT_GE(points, 5);
  }
}

TEST(Sources, TheCamerasViewIsAPartOfTheScan) {
  KittiSourceOptions options;
  options.root = street_folder();
  options.split = "train";
  const KittiSceneSource view(options, kClasses);
  options.all_round = true;
  const KittiSceneSource around(options, kClasses);
  ASSERT_EQ(view.size(), 1);
  const Scene part = view.scene(0), whole = around.scene(0);
  EXPECT_LT(part.cloud.size(), whole.cloud.size() / 2);
  EXPECT_LE(part.objects.size(), whole.objects.size());
  for (std::size_t i = 0; i < part.cloud.values.size(); i += 4) {
    ASSERT_GT(part.cloud.values[i], 0) << "the camera looks forward";
  }
  options.most = 1;
  options.split = "trainval";
  EXPECT_EQ(KittiSceneSource(options, kClasses).size(), 1);
}

TEST(Sources, RealFramesHaveTheirObjects) {
  ARBOX_REQUIRE_DATA(root, "kitti");
  KittiSourceOptions options;
  options.root = root;
  options.split = "sample";
  const KittiSceneSource source(options, kClasses);
  ASSERT_EQ(source.size(), 13);
  std::size_t objects = 0;
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const Scene scene = source.scene(i);
    objects += scene.objects.size();
    EXPECT_GT(scene.cloud.size(), 10000u);
    for (const std::int64_t points : count_points(scene.cloud, scene.objects)) EXPECT_GE(points, 1);
  }
  EXPECT_GT(objects, 20u);
}

TEST(Sources, TellWhatIsMissing) {
  KittiSourceOptions options;
  options.root = "/does/not/exist";
  EXPECT_THROW(KittiSceneSource(options, kClasses), IoError);
  options.root = street_folder();
  options.split = "other";
  EXPECT_THROW(KittiSceneSource(options, kClasses), InvalidArgument);
  const arbox::testing::TemporaryDirectory folder;
  std::filesystem::copy(street_folder(), folder.path(), std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(folder / "training/label_360");
  options.root = folder.path();
  options.split = "train";
  options.all_round = true;
  try {
    KittiSceneSource(options, kClasses).scene(0);
    ADD_FAILURE() << "expected an IoError";
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), HasSubstr("label_360"));
  }
  folder.write("ImageSets/train.txt", "");
  EXPECT_THROW(KittiSceneSource(options, kClasses), FormatError);
  SceneDataOptions data;
  data.kind = "elsewhere";
  EXPECT_THROW(make_scene_source(data, {"Car"}), ConfigError);
}

}  // namespace
}  // namespace arbox::training
