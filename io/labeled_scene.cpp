#include "arbox/io/labeled_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

constexpr std::array<std::string_view, 3> kFrames = {"lidar", "room", "camera"};
constexpr std::array<std::string_view, 3> kHeadings = {"known", "half", "unknown"};

template <class Names>
std::size_t index_named(const Names& names, std::string_view name, const char* what) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i;
  }
  throw InvalidArgument(std::string(what) + ": expected one of " + internal::joined(names, ", ") +
                        ", got " + internal::quoted_text(name));
}

/// From a frame to `room`.
Eigen::Matrix3d room_from(SceneFrame frame) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (frame == SceneFrame::kLidar) turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  if (frame == SceneFrame::kCamera) turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return turn;
}

void turn_columns(geometry::PointCloud& cloud, std::size_t first, const Eigen::Matrix3f& turn) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Eigen::Map<Eigen::Vector3f> vector(cloud.values.data() + i * cloud.columns() + first);
    vector = (turn * vector).eval();
  }
}

bool has_point(float depth) { return std::isfinite(depth) && depth > 0.0F; }

/// A box that is asked for many points.
class PointTest {
 public:
  PointTest(const geometry::Box& box, double margin)
      : center_(box.center),
        to_box_(box.rotation.conjugate().toRotationMatrix()),
        half_(0.5 * box.size.array() + margin),
        reach_(half_.norm()) {}

  bool contains(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d away = point - center_;
    // False for what is not finite, too.
    if (!(std::abs(away.x()) <= reach_ && std::abs(away.y()) <= reach_)) return false;
    return ((to_box_ * away).cwiseAbs().array() <= half_.array()).all();
  }

 private:
  Eigen::Vector3d center_;
  Eigen::Matrix3d to_box_;
  Eigen::Vector3d half_;
  double reach_;
};

}  // namespace

std::string_view name_of(SceneFrame frame) { return kFrames[static_cast<std::size_t>(frame)]; }

SceneFrame frame_named(std::string_view name) {
  return static_cast<SceneFrame>(index_named(kFrames, name, "frame"));
}

std::string_view name_of(Heading heading) { return kHeadings[static_cast<std::size_t>(heading)]; }

Heading heading_named(std::string_view name) {
  return static_cast<Heading>(index_named(kHeadings, name, "heading"));
}

LabeledScene converted(const LabeledScene& scene, SceneFrame frame) {
  LabeledScene result = scene;
  if (frame == scene.frame) return result;
  const Eigen::Matrix3d turn = room_from(frame).transpose() * room_from(scene.frame);
  result.frame = frame;
  turn_columns(result.cloud, 0, turn.cast<float>());
  const auto& channels = result.cloud.channels;
  const auto normals = std::find(channels.begin(), channels.end(), "normal_x");
  if (channels.end() - normals >= 3) {
    turn_columns(result.cloud, 3 + static_cast<std::size_t>(normals - channels.begin()),
                 turn.cast<float>());
  }
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = turn;
  for (LabeledObject& object : result.objects) {
    object.box = geometry::transformed(object.box, transform);
    object.written_yaw.reset();
  }
  if (result.photo) {
    result.photo->projection.leftCols<3>() =
        (scene.photo->projection.leftCols<3>() * turn.transpose()).eval();
  }
  result.calibration.reset();
  result.images.reset();
  return result;
}

std::vector<std::vector<std::int32_t>> points_in_boxes(const geometry::PointCloudView& cloud,
                                                       const std::vector<geometry::Box>& boxes,
                                                       double margin) {
  geometry::require_valid(boxes, "points_in_boxes");
  std::vector<PointTest> tests;
  for (const geometry::Box& box : boxes) tests.emplace_back(box, margin);
  std::vector<std::vector<std::int32_t>> inside(boxes.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = cloud.position(i).cast<double>();
    for (std::size_t b = 0; b < tests.size(); ++b) {
      if (tests[b].contains(point)) inside[b].push_back(static_cast<std::int32_t>(i));
    }
  }
  return inside;
}

std::vector<std::int32_t> pixels_of_cloud(const RgbdImages& images) {
  std::vector<std::int32_t> pixels;
  for (std::size_t i = 0; i < images.depth.size(); ++i) {
    if (has_point(images.depth[i])) pixels.push_back(static_cast<std::int32_t>(i));
  }
  return pixels;
}

geometry::PointCloud to_cloud(const RgbdImages& images) {
  geometry::PointCloud cloud;
  if (!images.rgb.empty()) cloud.channels = {"r", "g", "b"};
  if (!images.normals.empty()) {
    cloud.channels.insert(cloud.channels.end(), {"normal_x", "normal_y", "normal_z"});
  }
  const Eigen::Matrix3d inverse = images.intrinsic.inverse();
  const std::vector<std::int32_t> pixels = pixels_of_cloud(images);
  cloud.values.reserve(pixels.size() * cloud.columns());
  for (const std::int32_t pixel : pixels) {
    const Eigen::Vector3d ray =
        inverse * Eigen::Vector3d(pixel % images.width, pixel / images.width, 1.0);
    const Eigen::Vector3f point = (ray * static_cast<double>(images.depth[pixel])).cast<float>();
    cloud.values.insert(cloud.values.end(), {point.x(), point.y(), point.z()});
    const std::size_t at = 3 * static_cast<std::size_t>(pixel);
    for (std::size_t c = 0; c < 3 && !images.rgb.empty(); ++c) {
      cloud.values.push_back(static_cast<float>(images.rgb[at + c]) / 255.0F);
    }
    for (std::size_t c = 0; c < 3 && !images.normals.empty(); ++c) {
      cloud.values.push_back(images.normals[at + c]);
    }
  }
  return cloud;
}

}  // namespace arbox::io
