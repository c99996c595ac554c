#include "arbox/training/augmentation.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/geometry/overlap.h"
#include "arbox/training/points_in_boxes.h"
#include "arbox/training/scene_transform.h"
#include "training/made_scene.h"

namespace arbox::training {
namespace {

using geometry::Box;

/// Like points_inside with room for the rounding of points to float32.
std::vector<std::size_t> inside(const Scene& scene, Box box) {
  box.size.array() += 1e-4;
  return points_inside(scene.cloud, std::span(&box, 1)).front();
}

void expect_same_members(const Scene& before, const Scene& after) {
  ASSERT_EQ(before.objects.size(), after.objects.size());
  for (std::size_t i = 0; i < before.objects.size(); ++i) {
    EXPECT_EQ(inside(before, before.objects[i].box), inside(after, after.objects[i].box)) << i;
    EXPECT_FALSE(inside(before, before.objects[i].box).empty());
  }
}

void expect_near(const Scene& first, const Scene& second, double tolerance) {
  ASSERT_EQ(first.cloud.values.size(), second.cloud.values.size());
  for (std::size_t i = 0; i < first.cloud.values.size(); ++i) {
    ASSERT_NEAR(first.cloud.values[i], second.cloud.values[i], tolerance);
  }
  ASSERT_EQ(first.objects.size(), second.objects.size());
  for (std::size_t i = 0; i < first.objects.size(); ++i) {
    EXPECT_GT(geometry::overlap(first.objects[i].box, second.objects[i].box), 1 - 1e-6);
    EXPECT_NEAR(geometry::wrap_angle(geometry::yaw(first.objects[i].box) -
                                     geometry::yaw(second.objects[i].box)),
                0, 1e-9);
  }
}

/// Height of every point over the ground.
std::vector<double> clearances(const Scene& scene) {
  std::vector<double> result;
  const auto& values = scene.cloud.values;
  for (std::size_t i = 0; i < values.size(); i += 4) {
    result.push_back(values[i + 2] - ground_height(*scene.ground, values[i], values[i + 1]));
  }
  return result;
}

TEST(SceneTransform, PointsStayInTheirBoxesAndOverTheirGround) {
  const Scene scene = made_scene(1);
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& one) { flip_left_right(one); }, [](Scene& one) { flip_front_back(one); },
      [](Scene& one) { rotate(one, 2.4); }, [](Scene& one) { rotate(one, -0.3); }};
  for (const auto& change : changes) {
    Scene changed = scene;
    change(changed);
    expect_same_members(scene, changed);
    EXPECT_THAT(clearances(changed),
                ::testing::Pointwise(::testing::DoubleNear(1e-4), clearances(scene)));
  }
  Scene scaled = scene;
  scale(scaled, 1.04);
  expect_same_members(scene, scaled);
  EXPECT_NEAR(clearances(scaled)[0], 1.04 * clearances(scene)[0], 1e-4);
}

TEST(SceneTransform, MirrorsAndTurnsUndoThemselves) {
  const Scene scene = made_scene(2);
  Scene changed = scene;
  flip_left_right(changed);
  flip_left_right(changed);
  expect_near(scene, changed, 0);
  flip_front_back(changed);
  flip_front_back(changed);
  expect_near(scene, changed, 0);
  rotate(changed, 1.1);
  rotate(changed, -1.1);
  expect_near(scene, changed, 1e-5);
  Scene half = scene;
  flip_left_right(changed);
  flip_front_back(changed);
  rotate(half, std::numbers::pi);
  expect_near(half, changed, 1e-4);
}

TEST(SceneTransform, AHeadingTurnsWithItsCar) {
  Scene scene;
  SceneObject car;
  car.box = geometry::make_yaw_box({10, 2, 0}, {4, 2, 1.5}, 0.3);
  scene.objects = {car};
  flip_left_right(scene);
  EXPECT_NEAR(geometry::yaw(scene.objects[0].box), -0.3, 1e-12);
  EXPECT_EQ(scene.objects[0].box.center, Eigen::Vector3d(10, -2, 0));
  rotate(scene, std::numbers::pi / 2);
  EXPECT_NEAR(geometry::yaw(scene.objects[0].box), std::numbers::pi / 2 - 0.3, 1e-12);
  EXPECT_TRUE(scene.objects[0].box.center.isApprox(Eigen::Vector3d(2, 10, 0)));
}

TEST(SceneTransform, FactorsMustBeAboveZero) {
  Scene scene = made_scene(3);
  for (const double factor : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(scale(scene, factor), InvalidArgument);
  }
  EXPECT_THROW(ground_height({.normal = Eigen::Vector3d::UnitX(), .offset = 1}, 0, 0),
               InvalidArgument);
}

ObjectDatabase database_of(std::vector<Scene> scenes, const ObjectDatabaseOptions& options = {}) {
  return ObjectDatabase::build(ListedScenes(std::move(scenes)), options);
}

TEST(ObjectDatabase, HoldsTheObjectsOfEveryClassWithTheirPoints) {
  const Scene scene = made_scene(5);
  const ObjectDatabase database = database_of({scene, made_scene(6)});
  EXPECT_EQ(database.of(0).size(), 4u);
  EXPECT_EQ(database.of(1).size(), 2u);
  EXPECT_TRUE(database.of(2).empty());
  EXPECT_TRUE(database.of(kOtherObject).empty());
  const StoredObject& first = database.objects()[0];
  EXPECT_EQ(first.points.size(), 4 * count_points(scene.cloud, scene.objects)[0]);
  const Eigen::Vector3d& center = scene.objects[0].box.center;
  EXPECT_NEAR(first.clearance, -1.7 - ground_height(*scene.ground, center.x(), center.y()), 1e-9);
}

TEST(ObjectDatabase, LeavesOutWhatIsTooHardOrHasTooFewPoints) {
  Scene scene = made_scene(7);
  scene.objects[0].difficulty = -1;
  EXPECT_EQ(database_of({scene}).of(0).size(), 1u);
  EXPECT_EQ(database_of({scene}, {.min_points = 5, .keep_hardest = true, .most = 0}).of(0).size(),
            2u);
  EXPECT_EQ(
      database_of({scene}, {.min_points = 1000, .keep_hardest = true, .most = 0}).objects().size(),
      0u);
  EXPECT_EQ(
      database_of({scene, scene}, {.min_points = 1, .keep_hardest = true, .most = 3}).of(0).size(),
      3u);
}

TEST(PasteObjects, PastedPointsComeFirstAndNothingCollides) {
  const ObjectDatabase database = database_of({made_scene(8), made_scene(9), made_scene(10)});
  Scene scene = made_scene(11);
  const Scene before = scene;
  paste_objects(scene, database, {.counts = {15, 10}, .turn = std::numbers::pi},
                RandomStream(1, 2, 3));
  ASSERT_GT(scene.objects.size(), before.objects.size());
  std::size_t first = 0;
  for (std::size_t i = before.objects.size(); i < scene.objects.size(); ++i) {
    const Box& box = scene.objects[i].box;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_EQ(geometry::overlap(box, scene.objects[j].box,
                                  {.measure = geometry::Overlap::kIntersection,
                                   .space = geometry::OverlapSpace::kBirdsEye,
                                   .threads = 1}),
                0.0);
    }
    const auto members = inside(scene, box);
    ASSERT_FALSE(members.empty());
    EXPECT_EQ(members.front(), first);
    EXPECT_EQ(members.back() + 1 - members.front(), members.size()) << "pasted points alone";
    first += members.size();
    const double ground = ground_height(*scene.ground, box.center.x(), box.center.y());
    EXPECT_LT(std::abs(box.center.z() - 0.5 * box.size.z() - ground), 0.8);
  }
}

TEST(PasteObjects, AnObjectPastedOnItsOwnPlaceIsDropped) {
  const Scene scene = made_scene(12);
  Scene changed = scene;
  paste_objects(changed, database_of({scene}), {.counts = {20, 20}, .turn = 0.0},
                RandomStream(1, 2, 3));
  EXPECT_EQ(changed.objects.size(), scene.objects.size());
  EXPECT_EQ(changed.cloud.values, scene.cloud.values);
}

TEST(PasteObjects, WorksOnEmptyScenesAndWithEmptyDatabases) {
  Scene empty;
  empty.cloud.channels = {"intensity"};
  paste_objects(empty, database_of({made_scene(13)}), {.counts = {3}, .turn = 0.0},
                RandomStream(4, 5, 6));
  EXPECT_GE(empty.objects.size(), 1u);
  Scene scene = made_scene(13);
  const auto before = scene.cloud.values;
  paste_objects(scene, ObjectDatabase({}), {.counts = {3, 3, 3}, .turn = 0.0},
                RandomStream(4, 5, 6));
  EXPECT_EQ(scene.cloud.values, before);
  Scene narrow = made_scene(13);
  narrow.cloud.channels.clear();
  EXPECT_THROW(paste_objects(narrow, ObjectDatabase({}), {}, RandomStream(4, 5, 6)),
               InvalidArgument);
}

TEST(Augment, DependsOnSeedAndPlaceAlone) {
  const ObjectDatabase database = database_of({made_scene(14), made_scene(15)});
  const AugmentationOptions options = AugmentationOptions::all_round();
  const auto changed = [&](std::uint64_t seed, std::int64_t place) {
    Scene scene = made_scene(16);
    augment(scene, options, &database, seed, place);
    return scene;
  };
  EXPECT_EQ(changed(1, 5).cloud.values, changed(1, 5).cloud.values);
  EXPECT_NE(changed(1, 5).cloud.values, changed(1, 6).cloud.values);
  EXPECT_NE(changed(1, 5).cloud.values, changed(2, 5).cloud.values);
  for (std::int64_t place = 0; place < 20; ++place) {
    const Scene scene = changed(3, place);
    for (const SceneObject& object : scene.objects) {
      EXPECT_GE(inside(scene, object.box).size(), 5u);
    }
  }
}

TEST(Augment, MayBeSwitchedOffAndRefusesBadOptions) {
  Scene scene = made_scene(17);
  AugmentationOptions options;
  options.enabled = false;
  augment(scene, options, nullptr, 1, 2);
  EXPECT_EQ(scene.cloud.values, made_scene(17).cloud.values);
  options.scale_low = 1.2;
  EXPECT_THROW(augment(scene, options, nullptr, 1, 2), ConfigError);
  options = {};
  options.flip_left_right = 1.5;
  EXPECT_THROW(augment(scene, options, nullptr, 1, 2), ConfigError);
}

}  // namespace
}  // namespace arbox::training
