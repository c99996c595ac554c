#include "arbox/simulation/camera_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>

#include "arbox/base/error.h"
#include "arbox/simulation/models.h"
#include "arbox/simulation/street_stream.h"
#include "simulation/placed_model.h"

namespace arbox::simulation {
namespace {

struct Bounds {
  int left = 1 << 20, top = 1 << 20, right = -1, bottom = -1;
};

std::vector<Bounds> seen_bounds(const CameraImage& image, std::size_t objects) {
  std::vector<Bounds> result(objects);
  for (int i = 0; i < static_cast<int>(image.objects.size()); ++i) {
    const std::int32_t object = image.objects[i];
    if (object < 0) continue;
    Bounds& mine = result[object];
    const int x = i % image.picture.width, y = i / image.picture.width;
    mine = {std::min(mine.left, x), std::min(mine.top, y), std::max(mine.right, x),
            std::max(mine.bottom, y)};
  }
  return result;
}

TEST(CameraImage, PixelsOfALabelledObjectLieInItsImageBoxAndFillIt) {
  int labels = 0, whole = 0;
  for (std::uint64_t index = 0; index < 8; ++index) {
    const StreetScan scan = street_scan({}, 31, index);
    const CameraImage image = render_camera_image(scan.scene, scan.camera, {.samples = 1});
    const auto seen = seen_bounds(image, scan.scene.objects.size());
    for (std::size_t i = 0; i < scan.labels.image_objects.size(); ++i) {
      const io::KittiObject& label = scan.labels.image[i];
      const Bounds& mine = seen[scan.labels.image_objects[i]];
      if (label.z < 0.5 * label.length + 1.0) continue;
      SCOPED_TRACE(testing::Message() << "street " << index << " " << label.type);
      ++labels;
      ASSERT_GE(mine.right, 0) << "nothing to be seen";
      EXPECT_GT(mine.left, label.left - 0.1);
      EXPECT_GT(mine.top, label.top - 0.1);
      EXPECT_LT(mine.right, label.right + 0.1);
      EXPECT_LT(mine.bottom, label.bottom + 0.1);
      if (label.occlusion != 0 || label.truncation > 0.0) continue;
      ++whole;
      EXPECT_GT(mine.right - mine.left + 2.0, 0.75 * (label.right - label.left));
      EXPECT_GT(mine.bottom - mine.top + 2.0, 0.75 * (label.bottom - label.top));
    }
  }
  EXPECT_GT(labels, 20);
  EXPECT_GT(whole, 8);
}

TEST(CameraImage, WhatNoLabelNamesIsHiddenOrSmall) {
  for (std::uint64_t index = 0; index < 4; ++index) {
    const StreetScan scan = street_scan({}, 31, index);
    const CameraImage image = render_camera_image(scan.scene, scan.camera, {.samples = 1});
    std::vector<int> pixels(scan.scene.objects.size());
    for (const std::int32_t object : image.objects) {
      if (object >= 0) ++pixels[object];
    }
    for (const std::size_t object : scan.labels.around_objects) {
      if (scan.scene.objects[object].box.center.x() < 4.0) continue;
      EXPECT_LT(pixels[object], 2500) << scan.scene.objects[object].label;
    }
  }
}

/// A wall across the view, `distance` metres ahead.
void add_wall(Scene& scene, float distance, Material material, std::int32_t object = -1) {
  const auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {
      {distance, -60, -30}, {distance, 60, -30}, {distance, 60, 30}, {distance, -60, 30}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh->materials.assign(2, material);
  Instance instance;
  instance.mesh = mesh;
  instance.object = object;
  scene.instances.push_back(instance);
}

/// Asphalt 1.7 m below the scanner, from 2 to 80 m ahead.
Scene plain_road() {
  Scene scene;
  const auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{2, -40, -1.7f}, {80, -40, -1.7f}, {80, 40, -1.7f}, {2, 40, -1.7f}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh->materials.assign(2, Material::kAsphalt);
  Instance instance;
  instance.mesh = mesh;
  scene.instances.push_back(instance);
  return scene;
}

double lightness(const drawing::Image& image, int first_row, int last_row) {
  double sum = 0.0;
  for (int y = first_row; y < last_row; ++y) {
    for (int x = 0; x < image.width; ++x) sum += image.at(x, y).g;
  }
  return sum / (image.width * (last_row - first_row));
}

drawing::Image picture_of(const Scene& scene, int samples = 1) {
  return render_camera_image(scene, kitti_camera(0), {.samples = samples}).picture;
}

TEST(CameraImage, AnEmptyWorldHasSkyAboveLand) {
  const CameraImage image = render_camera_image(Scene{}, kitti_camera(0), {.samples = 1});
  EXPECT_EQ(image.picture.width, 1242);
  EXPECT_EQ(image.picture.height, 375);
  EXPECT_EQ(image.objects, std::vector<std::int32_t>(1242 * 375, -1));
  const drawing::Color sky = image.picture.at(600, 5), land = image.picture.at(600, 370);
  EXPECT_GT(sky.b, sky.r);
  EXPECT_GT(land.g, land.b);
}

TEST(CameraImage, LinesOnTheRoadAreBrighterThanTheRoad) {
  Scene scene = plain_road();
  const double bare = lightness(picture_of(scene), 250, 370);
  scene.markings.lines = {{0.0, false}, {2.5, false}};
  const double solid = lightness(picture_of(scene), 250, 370);
  scene.markings.lines = {{0.0, true}, {2.5, true}};
  const double dashed = lightness(picture_of(scene), 250, 370);
  scene.markings.gaps = {{-100, 100, true}, {-100, 100, false}};
  const double none = lightness(picture_of(scene), 250, 370);
  EXPECT_GT(dashed, bare + 0.5);
  EXPECT_GT(solid, dashed + 0.5);
  EXPECT_EQ(none, bare);
}

TEST(CameraImage, LinesFollowABendingRoad) {
  Scene scene = plain_road();
  scene.markings.lines = {{1.0, false}};
  for (const double curvature : {0.01, -0.01}) {
    scene.markings.curvature = curvature;
    const drawing::Image image = picture_of(scene);
    const CameraView camera = kitti_camera(0);
    const Eigen::Matrix<double, 3, 4> map =
        camera.calibration.p2() * camera.calibration.rect_from_lidar().matrix();
    const double angle = 12.0 * curvature, radius = 1.0 / curvature;
    const Eigen::Vector3d on_line((radius - 1.0) * std::sin(angle),
                                  radius - (radius - 1.0) * std::cos(angle), -1.7);
    const Eigen::Vector3d pixel = map * on_line.homogeneous();
    const int x = static_cast<int>(std::lround(pixel.x() / pixel.z())),
              y = static_cast<int>(std::lround(pixel.y() / pixel.z()));
    EXPECT_GT(image.at(x, y).g, image.at(x + 25, y).g + 40);
    EXPECT_GT(image.at(x, y).g, image.at(x - 25, y).g + 40);
  }
}

TEST(CameraImage, ARoofTakesTheLightOfSunAndSky) {
  const Scene open = plain_road();
  Scene roofed = open;
  const auto roof = std::make_shared<TriangleMesh>(*open.instances[0].mesh);
  for (Eigen::Vector3f& vertex : roof->vertices) vertex = {1.3f * vertex.x() - 40, vertex.y(), 6};
  Instance instance;
  instance.mesh = roof;
  roofed.instances.push_back(instance);
  EXPECT_LT(lightness(picture_of(roofed), 300, 370), lightness(picture_of(open), 300, 370) - 5.0);
}

TEST(CameraImage, PanesAreSeenThroughAndCountAsTheirObject) {
  const auto with_walls = [](bool pane, Material behind) {
    Scene scene;
    scene.objects.push_back({.label = "Car",
                             .box = geometry::make_yaw_box({10, 0, 0}, {4, 2, 2}, 0.0),
                             .velocity = Eigen::Vector3d::Zero()});
    if (pane) add_wall(scene, 10, Material::kGlass, 0);
    add_wall(scene, 12, behind);
    return render_camera_image(scene, kitti_camera(0), {.samples = 1});
  };
  const CameraImage bare = with_walls(false, Material::kRubber);
  const CameraImage dark = with_walls(true, Material::kRubber);
  const CameraImage light = with_walls(true, Material::kPlaster);
  EXPECT_EQ(bare.objects, std::vector<std::int32_t>(bare.objects.size(), -1));
  EXPECT_EQ(dark.objects, std::vector<std::int32_t>(dark.objects.size(), 0));
  EXPECT_NE(bare.picture.pixels, dark.picture.pixels);
  EXPECT_GT(lightness(light.picture, 0, 375), lightness(dark.picture, 0, 375) + 10.0);
}

/// Two cars side by side; the first has this brightness.
Scene side_by_side(double brightness) {
  Scene scene;
  for (const double y : {-2.0, 2.0}) place_car(scene, ModelKind::kHatchback, {12, y, -1});
  scene.instances[0].brightness = brightness;
  return scene;
}

/// Mean red, green and blue of the pixels of each of two objects.
std::array<Eigen::Vector3d, 2> mean_colors(const Scene& scene) {
  const CameraImage image = render_camera_image(scene, kitti_camera(0), {.samples = 1});
  std::array<Eigen::Vector3d, 2> sum = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::array<int, 2> count = {};
  for (std::size_t i = 0; i < image.objects.size(); ++i) {
    const std::int32_t object = image.objects[i];
    if (object < 0) continue;
    const std::uint8_t* pixel = &image.picture.pixels[3 * i];
    sum[object] += Eigen::Vector3d(pixel[0], pixel[1], pixel[2]);
    ++count[object];
  }
  EXPECT_GT(count[0], 1000);
  EXPECT_GT(count[1], 1000);
  return {sum[0] / count[0], sum[1] / count[1]};
}

TEST(CameraImage, PaintThatIsDarkToTheLaserIsDarkInThePicture) {
  const auto dark = mean_colors(side_by_side(0.1)), light = mean_colors(side_by_side(1.2));
  EXPECT_LT(dark[0].sum(), light[0].sum() - 20.0);
  EXPECT_NEAR(dark[1].sum(), light[1].sum(), 3.0);
}

TEST(CameraImage, CarsHaveColorsOfTheirOwn) {
  int different = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Scene scene = side_by_side(1.0);
    scene.seed = seed;
    const auto colors = mean_colors(scene);
    different += (colors[0] - colors[1]).cwiseAbs().maxCoeff() > 10.0;
  }
  EXPECT_GE(different, 2);
}

TEST(CameraImage, MoreRaysSmoothEdgesAndKeepTheLight) {
  const StreetScan scan = street_scan({}, 31, 2);
  const drawing::Image rough = render_camera_image(scan.scene, scan.camera, {.samples = 1}).picture;
  const drawing::Image fine = render_camera_image(scan.scene, scan.camera, {.samples = 2}).picture;
  const auto steps = [](const drawing::Image& image) {
    double sum = 0.0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 1; x < image.width; ++x) {
        sum += std::abs(image.at(x, y).g - image.at(x - 1, y).g);
      }
    }
    return sum;
  };
  EXPECT_LT(steps(fine), 0.95 * steps(rough));
  EXPECT_NEAR(lightness(fine, 0, fine.height), lightness(rough, 0, rough.height), 3.0);
}

TEST(CameraImage, EqualScenesGiveEqualPicturesFromAnyThread) {
  const StreetScan scan = street_scan({}, 31, 1);
  const auto render = [&] {
    return render_camera_image(scan.scene, scan.camera, {.samples = 1}).picture.pixels;
  };
  auto other = std::async(std::launch::async, render);
  const auto here = render();
  EXPECT_EQ(here, other.get());
}

TEST(CameraImage, ImpossibleOptionsAndImagesAreRefused) {
  EXPECT_THROW(render_camera_image(Scene{}, kitti_camera(0), {.samples = 0}), ConfigError);
  EXPECT_THROW(render_camera_image(Scene{}, kitti_camera(0), {.samples = 9}), ConfigError);
  CameraView camera = kitti_camera(0);
  camera.image = {0, 375};
  EXPECT_THROW(render_camera_image(Scene{}, camera), InvalidArgument);
  camera.image = {1242, 20000};
  EXPECT_THROW(render_camera_image(Scene{}, camera), InvalidArgument);
}

}  // namespace
}  // namespace arbox::simulation
