#include "arbox/drawing/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "arbox/base/error.h"
#include "drawing/pixels.h"

namespace arbox::drawing {
namespace {

using geometry::Detection;
using geometry::PointCloud;

const Color kCar = class_color("Car");
const Color kPedestrian = class_color("Pedestrian");

Detection detection(const std::string& label, const Eigen::Vector3d& center, double score = 0.9,
                    double yaw = 0.0) {
  Detection result;
  result.label = label;
  result.score = score;
  result.box = geometry::make_yaw_box(center, {4.0, 2.0, 1.5}, yaw);
  return result;
}

PointCloud flat_cloud(int count, double reach) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(static_cast<float>(-reach),
                                              static_cast<float>(reach));
  PointCloud cloud;
  cloud.channels = {"intensity"};
  for (int i = 0; i < count; ++i) {
    for (const float v : {place(random), place(random), -1.7f, 0.5f}) cloud.values.push_back(v);
  }
  return cloud;
}

SceneOptions birdseye(int width = 600) {
  SceneOptions options;
  options.view = SceneView::kBirdseye;
  options.width = width;
  options.captions = false;
  return options;
}

// Middle of the rectangle around all pixels of a colour.
Eigen::Vector2d middle_of(const Image& image, Color color, int bottom) {
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int y = 0; y < bottom; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!close(image.at(x, y), color, 25)) continue;
      low = low.cwiseMin(Eigen::Vector2d(x, y));
      high = high.cwiseMax(Eigen::Vector2d(x, y));
    }
  }
  EXPECT_LT(low.x(), high.x());
  return (low + high) / 2;
}

Photo forward_photo(int width, int height) {
  Photo photo;
  photo.image = Image(width, height, {255, 255, 255});
  photo.projection << width / 2.0, -width, 0, 0, height / 2.0, 0, -width, 0, 1, 0, 0, 0;
  return photo;
}

TEST(Scene, AnEmptySceneIsAPicture) {
  for (const auto view : {SceneView::kBirdseye, SceneView::kPerspective, SceneView::kBoth}) {
    const Image image = draw_scene({}, {.view = view, .width = 400});
    EXPECT_EQ(image.width, 400);
    EXPECT_GT(image.height, 100);
  }
}

TEST(Scene, BoxesStandWhereTheyShouldFromAbove) {
  Scene scene;
  scene.predictions = {detection("Car", {10, 5, 0}), detection("Pedestrian", {-10, -5, 0})};
  SceneOptions options = birdseye(1400);
  options.range = 20.0;
  const Image image = draw_scene(scene, options);
  const int bottom = image.height - 60;  // above the legend
  const Eigen::Vector2d car = middle_of(image, kCar, bottom);
  const Eigen::Vector2d pedestrian = middle_of(image, kPedestrian, bottom);
  // 20 m ahead and 10 m to the left: up and left by the same scale.
  const Eigen::Vector2d way = car - pedestrian;
  EXPECT_LT(way.x(), 0.0);
  EXPECT_LT(way.y(), 0.0);
  EXPECT_NEAR(way.y() / way.x(), 2.0, 0.03);
  EXPECT_NEAR((car + pedestrian).x() / 2, image.width / 2.0, 2.0);
}

// Lower right, where the axes stand when nothing else does.
TEST(Scene, AxesKeepOffABoxInTheirCorner) {
  constexpr Color kAxisX = {200, 50, 40};
  SceneOptions options = birdseye(1000);
  options.range = 20.0;
  Scene scene;
  scene.predictions = {detection("Car", {0, 0, 0})};
  const Image clear = draw_scene(scene, options);
  const Eigen::Vector2d usual = middle_of(clear, kAxisX, clear.height - 60);
  EXPECT_GT(usual.x(), 800.0);
  EXPECT_GT(usual.y(), 800.0);
  scene.predictions.push_back(detection("Car", {-18, -18, 0}));
  const Image filled = draw_scene(scene, options);
  EXPECT_LT(middle_of(filled, kAxisX, filled.height - 60).y(), 200.0);
}

TEST(Scene, HeadingMarksPointForward) {
  Scene scene;
  SceneOptions options = birdseye();
  options.range = 5.0;
  scene.predictions = {detection("Car", {0, 0, 0}, 0.9, 0.0)};
  const Image ahead = draw_scene(scene, options);
  scene.predictions[0].box = geometry::make_yaw_box({0, 0, 0}, {4, 2, 1.5}, M_PI);
  const Image back = draw_scene(scene, options);
  const auto inked_rows = [](const Image& image) {
    const int middle = image.width / 2;
    double sum = 0.0, count = 0.0;
    for (int y = 0; y < image.width; ++y) {
      const Color color = image.at(middle - 8, y);
      const double ink = std::max(0, color.r - color.b - 60);
      sum += ink * y;
      count += ink;
    }
    return sum / count;
  };
  EXPECT_LT(inked_rows(ahead) + 10.0, inked_rows(back));
}

TEST(Scene, BoxesWithoutAFrontHaveNoHeadingMark) {
  // Turned by half a turn a box without a front is the same picture, one with a front is not.
  const auto drawn = [](double yaw, const std::vector<bool>& fronts) {
    Scene scene;
    scene.truth = {detection("Car", {0, 0, 0}, 1.0, yaw)};
    scene.truth_has_front = fronts;
    SceneOptions options = birdseye();
    options.range = 8.0;
    return draw_scene(scene, options).pixels;
  };
  const double half = std::acos(-1.0);
  EXPECT_NE(drawn(0.0, {true}), drawn(half, {true}));
  EXPECT_EQ(drawn(0.0, {true}), drawn(0.0, {}));
  const auto one = drawn(0.0, {false}), other = drawn(half, {false});
  std::size_t different = 0;
  // Dashes begin at other corners.
  for (std::size_t i = 0; i < one.size(); ++i) different += one[i] != other[i] ? 1 : 0;
  EXPECT_LT(different, one.size() / 100);
  EXPECT_NE(one, drawn(0.0, {true}));
}

TEST(Scene, TruthIsDashedAndPredictionsAreNot) {
  Scene predicted, labelled;
  predicted.predictions = labelled.truth = {detection("Car", {5, 0, 0})};
  SceneOptions options = birdseye(1400);
  options.range = 10.0;
  const int solid = count_color(draw_scene(predicted, options), kCar, 10);
  const int dashed = count_color(draw_scene(labelled, options), kCar, 10);
  EXPECT_GT(dashed, solid / 5);
  EXPECT_LT(dashed, solid * 4 / 5);
}

TEST(Scene, LowScoresAreLeftOut) {
  Scene scene;
  scene.predictions = {detection("Car", {5, 0, 0}, 0.8), detection("Pedestrian", {5, 5, 0}, 0.2)};
  SceneOptions options = birdseye();
  EXPECT_GT(count_color(draw_scene(scene, options), kPedestrian, 10), 0);
  options.minimum_score = 0.5;
  EXPECT_EQ(count_color(draw_scene(scene, options), kPedestrian, 10), 0);
  EXPECT_GT(count_color(draw_scene(scene, options), kCar, 10), 0);
}

TEST(Scene, LabelsTitleAndUncertaintyChangeThePicture) {
  Scene scene;
  scene.predictions = {detection("Car", {5, 0, 0})};
  SceneOptions options = birdseye();
  const Image plain = draw_scene(scene, options);
  options.captions = true;
  EXPECT_NE(draw_scene(scene, options).pixels, plain.pixels);
  options.captions = false;
  options.title = "A title";
  EXPECT_GT(draw_scene(scene, options).height, plain.height);
  options.title.clear();
  Scene uncertain = scene;
  uncertain.predictions[0].quantile_boxes = {{0.1, scene.predictions[0].box, false}};
  uncertain.predictions[0].quantile_boxes[0].box.size *= 2.0;
  EXPECT_NE(draw_scene(uncertain, options).pixels, plain.pixels);
  uncertain = scene;
  uncertain.predictions[0].confidence_boxes = {
      {0.9, geometry::make_yaw_box({5, 0, 0}, {6, 4, 3}, 0)}};
  EXPECT_NE(draw_scene(uncertain, options).pixels, plain.pixels);
  uncertain = scene;
  uncertain.predictions[0].samples = {geometry::make_yaw_box({5, 1, 0}, {4, 2, 2}, 0.2)};
  EXPECT_NE(draw_scene(uncertain, options).pixels, plain.pixels);
}

TEST(Scene, NonFinitePointsChangeNothing) {
  const PointCloud clean = flat_cloud(2000, 20.0);
  PointCloud broken = clean;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float v : {nan, 1.0f, 1.0f, 0.5f, 1.0f, -inf, 1.0f, 0.5f}) broken.values.push_back(v);
  Scene scene;
  scene.cloud = clean.view();
  const Image image = draw_scene(scene, {.width = 600});
  scene.cloud = broken.view();
  EXPECT_EQ(draw_scene(scene, {.width = 600}).pixels, image.pixels);
}

TEST(Scene, FarAwayPointsDoNotShrinkTheRest) {
  PointCloud cloud = flat_cloud(2000, 20.0);
  for (const float v : {1e30f, -1e30f, 1e30f, 0.5f}) cloud.values.push_back(v);
  Scene scene;
  scene.cloud = cloud.view();
  SceneOptions options = birdseye();
  const Image image = draw_scene(scene, options);
  int inked = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Color color = image.at(x, y);
      inked += color.b > color.r + 40;
    }
  }
  EXPECT_GT(inked, 4000);
}

TEST(Scene, EqualInputGivesEqualPixels) {
  const PointCloud cloud = flat_cloud(5000, 30.0);
  Scene scene;
  scene.cloud = cloud.view();
  scene.predictions = {detection("Car", {10, 5, -1}), detection("Van", {10, 7, -1})};
  EXPECT_EQ(draw_scene(scene).pixels, draw_scene(scene).pixels);
}

TEST(Scene, PhotoBoxesAreWhereTheProjectionSays) {
  Scene scene;
  scene.photo = forward_photo(580, 300);
  SceneOptions options = birdseye();
  const Image without = draw_scene(scene, options);
  scene.predictions = {detection("Car", {20, 0, 0})};
  const Image image = draw_scene(scene, options);
  // The strip is as wide as the picture but for its margins, so it is about the photo's size.
  const int strip = 300;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int y = 0; y < strip; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!close(image.at(x, y), kCar, 20)) continue;
      low = low.cwiseMin(Eigen::Vector2d(x, y));
      high = high.cwiseMax(Eigen::Vector2d(x, y));
    }
  }
  const double left = (image.width - 580) / 2.0;
  EXPECT_NEAR(low.x(), left + 290 - 580.0 / 18, 4.0);
  EXPECT_NEAR(high.x(), left + 290 + 580.0 / 18, 4.0);
  EXPECT_NEAR(high.y() - low.y(), 580 * 1.5 / 18, 5.0);
}

TEST(Scene, ABoxBehindTheCameraIsNotOnThePhoto) {
  Scene scene;
  scene.photo = forward_photo(580, 300);
  scene.predictions = {detection("Car", {-20, 0, 0})};
  const Image image = draw_scene(scene, birdseye());
  EXPECT_EQ(count_color(image, kCar, 0, 0, image.width, 300, 40), 0);
}

TEST(Scene, ABoxAroundTheCameraDoesNotWrap) {
  Scene scene;
  scene.photo = forward_photo(580, 300);
  // Below the camera: whatever of it is seen lies under the horizon.
  scene.predictions = {detection("Car", {0, 0, -3})};
  const Image image = draw_scene(scene, birdseye());
  EXPECT_EQ(count_color(image, kCar, 0, 0, image.width, 150, 40), 0);
}

TEST(Scene, SizesAreAsAsked) {
  const Image image = draw_scene({}, {.width = 640, .height = 480});
  EXPECT_EQ(image.width, 640);
  EXPECT_EQ(image.height, 480);
}

TEST(Scene, ColorsByIntensityAndByOwnColors) {
  PointCloud cloud;
  cloud.channels = {"r", "g", "b", "intensity"};
  for (int i = 0; i < 400; ++i) {
    for (const float v : {0.1f * (i % 20), 0.1f * (i / 20), 0.0f, 1.0f, 0.0f, 0.0f, 0.02f * i}) {
      cloud.values.push_back(v);
    }
  }
  Scene scene;
  scene.cloud = cloud.view();
  SceneOptions options = birdseye();
  options.color = PointColor::kRgb;
  const Image own = draw_scene(scene, options);
  EXPECT_GT(count_color(own, {255, 0, 0}, 40), 200);
  options.color = PointColor::kIntensity;
  EXPECT_EQ(count_color(draw_scene(scene, options), {255, 0, 0}, 40), 0);
}

TEST(Scene, RefusesWhatDoesNotFit) {
  const auto refused = [](const SceneOptions& options) {
    EXPECT_THROW(draw_scene({}, options), Error);
  };
  refused({.view = static_cast<SceneView>(7)});
  refused({.width = 3});
  refused({.width = 100000});
  refused({.width = 640, .height = 20});
  refused({.range = -1.0});
  refused({.azimuth = std::numeric_limits<double>::quiet_NaN()});
  refused({.elevation = 90.0});
  refused({.minimum_score = 2.0});
  Scene scene;
  scene.predictions = {detection("Car", {0, 0, 0})};
  scene.predictions[0].box.size.x() = -1.0;
  EXPECT_THROW(draw_scene(scene), InvalidArgument);
  scene = {};
  scene.photo = forward_photo(50, 50);
  scene.photo->projection(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(draw_scene(scene), InvalidArgument);
  scene = {};
  scene.truth_has_front = {true};
  EXPECT_THROW(draw_scene(scene), InvalidArgument);
  PointCloud cloud;
  cloud.values = {0.0f, 0.0f, 0.0f};
  scene = {};
  scene.cloud = cloud.view();
  SceneOptions options;
  options.color = PointColor::kIntensity;
  EXPECT_THROW(draw_scene(scene, options), InvalidArgument);
}

}  // namespace
}  // namespace arbox::drawing
