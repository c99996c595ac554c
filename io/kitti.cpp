#include "arbox/io/kitti.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/io/kitti_label.h"

namespace arbox::io {
namespace {

using geometry::Box;
using geometry::Detection;

constexpr double kTiltTolerance = 1e-6;
constexpr double kNearestDepth = 0.1;
constexpr double kQuarterTurn = std::numbers::pi / 2;

double heading_to_rotation_y(double heading) {
  return geometry::wrap_angle(-heading - kQuarterTurn);
}

KittiCalibration renamed_axes() {
  KittiCalibration calibration;
  calibration.velodyne_to_camera.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return calibration;
}

class BoxAroundPixels {
 public:
  void add(const Eigen::Vector3d& homogeneous) {
    const Eigen::Vector2d pixel = homogeneous.head<2>() / homogeneous.z();
    low_ = low_.cwiseMin(pixel);
    high_ = high_.cwiseMax(pixel);
  }
  std::optional<ImageBox> box() const {
    if (!(low_.x() <= high_.x())) return std::nullopt;
    return ImageBox{low_.x(), low_.y(), high_.x(), high_.y()};
  }

 private:
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_ = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());
};

KittiObject placed(const Detection& detection, const KittiCalibration& calibration) {
  KittiObject object = to_kitti_object(detection.box, calibration);
  object.type = detection.label;
  object.score = detection.score;
  return object;
}

}  // namespace

Box to_box(const KittiObject& object, const KittiCalibration& calibration) {
  if (!has_box(object)) {
    throw InvalidArgument("to_box: an object of type " + object.type +
                          " has no place in space; ask has_box() first");
  }
  Eigen::Vector3d center =
      calibration.lidar_from_rect() * Eigen::Vector3d(object.x, object.y, object.z);
  center.z() += 0.5 * object.height;
  return geometry::make_yaw_box(center, {object.length, object.width, object.height},
                                geometry::wrap_angle(-(object.rotation_y + kQuarterTurn)));
}

std::vector<Detection> to_detections(std::span<const KittiObject> objects,
                                     const KittiCalibration& calibration) {
  std::vector<Detection> detections;
  for (const KittiObject& object : objects) {
    if (!has_box(object)) continue;
    Detection& detection = detections.emplace_back();
    detection.label = object.type;
    detection.score = object.score;
    detection.box = to_box(object, calibration);
  }
  return detections;
}

KittiObject to_kitti_object(const Box& box, const KittiCalibration& calibration) {
  geometry::require_valid(box, "to_kitti_object");
  if (!geometry::is_yaw_only(box, kTiltTolerance)) {
    throw InvalidArgument(
        "to_kitti_object: expected a box whose rotation is about z, got a tilted one, which "
        "KITTI's files cannot hold; write JSON or CSV");
  }
  const Eigen::Vector3d bottom =
      calibration.rect_from_lidar() *
      Eigen::Vector3d(box.center - Eigen::Vector3d(0, 0, 0.5 * box.size.z()));
  KittiObject object;
  object.height = box.size.z();
  object.width = box.size.y();
  object.length = box.size.x();
  object.x = bottom.x();
  object.y = bottom.y();
  object.z = bottom.z();
  object.rotation_y = heading_to_rotation_y(geometry::yaw(box));
  return object;
}

std::array<Eigen::Vector3d, 8> rect_corners(const KittiObject& object) {
  const double cosine = std::cos(object.rotation_y);
  const double sine = std::sin(object.rotation_y);
  std::array<Eigen::Vector3d, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const double along = ((i & 1) ? 0.5 : -0.5) * object.length;
    const double across = ((i & 2) ? 0.5 : -0.5) * object.width;
    corners[i] = {object.x + cosine * along + sine * across,
                  object.y - ((i & 4) ? object.height : 0.0),
                  object.z - sine * along + cosine * across};
  }
  return corners;
}

Eigen::Vector3d project(const Eigen::Vector3d& point, const KittiCalibration& calibration) {
  const Eigen::Vector3d rect = calibration.rect_from_lidar() * point;
  const Eigen::Vector3d pixel = calibration.p2() * rect.homogeneous();
  return {pixel.x() / pixel.z(), pixel.y() / pixel.z(), pixel.z()};
}

std::optional<ImageBox> projected_box(const KittiObject& object,
                                      const KittiCalibration& calibration) {
  std::array<Eigen::Vector3d, 8> pixels;
  const auto corners = rect_corners(object);
  std::transform(corners.begin(), corners.end(), pixels.begin(), [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(calibration.p2() * p.homogeneous());
  });
  BoxAroundPixels around;
  for (int i = 0; i < 8; ++i) {
    const bool in_front = pixels[i].z() >= kNearestDepth;
    if (in_front) around.add(pixels[i]);
    for (const int bit : {1, 2, 4}) {
      const int j = i ^ bit;
      if (j < i || in_front == (pixels[j].z() >= kNearestDepth)) continue;
      const double t = (kNearestDepth - pixels[i].z()) / (pixels[j].z() - pixels[i].z());
      around.add(pixels[i] + t * (pixels[j] - pixels[i]));
    }
  }
  return around.box();
}

std::optional<ImageBox> clipped(const ImageBox& box, const ImageSize& image) {
  const ImageBox result{std::max(box.left, 0.0), std::max(box.top, 0.0),
                        std::min(box.right, image.width - 1.0),
                        std::min(box.bottom, image.height - 1.0)};
  if (!(result.left < result.right && result.top < result.bottom)) return std::nullopt;
  return result;
}

double observation_angle(const KittiObject& object) {
  return geometry::wrap_angle(object.rotation_y - std::atan2(object.x, object.z));
}

std::vector<KittiObject> to_kitti_results(std::span<const Detection> detections,
                                          const KittiCalibration& calibration,
                                          const ImageSize& image) {
  std::vector<KittiObject> objects;
  for (const Detection& detection : detections) {
    KittiObject object = placed(detection, calibration);
    const auto whole = projected_box(object, calibration);
    const auto seen = whole ? clipped(*whole, image) : std::nullopt;
    if (!seen) continue;
    object.left = seen->left;
    object.top = seen->top;
    object.right = seen->right;
    object.bottom = seen->bottom;
    object.alpha = observation_angle(object);
    objects.push_back(object);
  }
  return objects;
}

std::vector<KittiObject> to_kitti_results(std::span<const Detection> detections) {
  const KittiCalibration calibration = renamed_axes();
  std::vector<KittiObject> objects;
  for (const Detection& detection : detections) {
    KittiObject& object = objects.emplace_back(placed(detection, calibration));
    object.left = object.top = object.right = object.bottom = -1;
  }
  return objects;
}

std::vector<std::size_t> points_in_image(const geometry::PointCloudView& cloud,
                                         const KittiCalibration& calibration,
                                         const ImageSize& image) {
  const Projection pixels_from_lidar = image_from_lidar(calibration);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d pixel =
        pixels_from_lidar * cloud.position(i).cast<double>().homogeneous();
    const double depth = pixel.z();
    // Written so that NaN is outside.
    if (depth > 0 && pixel.x() >= 0 && pixel.x() < image.width * depth && pixel.y() >= 0 &&
        pixel.y() < image.height * depth) {
      indices.push_back(i);
    }
  }
  return indices;
}

geometry::PointCloud crop_to_image(const geometry::PointCloudView& cloud,
                                   const KittiCalibration& calibration, const ImageSize& image) {
  geometry::PointCloud result;
  for (const auto& channel : cloud.channels()) result.channels.push_back(channel.name);
  for (const std::size_t i : points_in_image(cloud, calibration, image)) {
    const Eigen::Vector3f position = cloud.position(i);
    result.values.insert(result.values.end(), position.data(), position.data() + 3);
    for (const auto& channel : cloud.channels()) {
      result.values.push_back(static_cast<float>(cloud.value(channel, i)));
    }
  }
  return result;
}

}  // namespace arbox::io
