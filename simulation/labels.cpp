#include "arbox/simulation/labels.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/random.h"
#include "arbox/io/kitti.h"
#include "arbox/simulation/internal/projector.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kAnnotator = 200;
constexpr double kNearestDepth = 0.3;
constexpr int kRaysAcross = 12;
constexpr int kMostSurfaces = 16;

/// The object in the image before and after its borders cut it.
struct Outline {
  io::ImageBox whole, cut;
  double truncation = 1.0;
};

/// Bounds of the projected vertices of every object.
std::vector<std::optional<Outline>> outlines(const Scene& scene, const Projector& projector,
                                             const io::ImageSize& image) {
  struct Bounds {
    io::ImageBox box{1e9, 1e9, -1e9, -1e9};
    std::int64_t seen = 0, total = 0, behind = 0;
  };
  std::vector<Bounds> bounds(scene.objects.size());
  for (const Instance& instance : scene.instances) {
    if (instance.object < 0) continue;
    Bounds& mine = bounds[instance.object];
    const Eigen::Matrix<double, 3, 4> map = projector.matrix * instance.pose.matrix();
    for (const Eigen::Vector3f& vertex : instance.mesh->vertices) {
      const Eigen::Vector3d pixel = map * vertex.cast<double>().homogeneous();
      ++mine.total;
      if (pixel.z() < kNearestDepth) {
        ++mine.behind;
        continue;
      }
      const double u = pixel.x() / pixel.z(), v = pixel.y() / pixel.z();
      mine.box = {std::min(mine.box.left, u), std::min(mine.box.top, v),
                  std::max(mine.box.right, u), std::max(mine.box.bottom, v)};
      mine.seen += u >= 0 && u < image.width && v >= 0 && v < image.height;
    }
  }
  std::vector<std::optional<Outline>> result(bounds.size());
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const Bounds& mine = bounds[i];
    if (mine.seen == 0) continue;
    const auto cut = io::clipped(mine.box, image);
    if (!cut) continue;
    const auto area = [](const io::ImageBox& box) {
      return (box.right - box.left) * (box.bottom - box.top);
    };
    const double by_area = 1.0 - area(*cut) / area(mine.box);
    const double by_count = 1.0 - static_cast<double>(mine.seen) / static_cast<double>(mine.total);
    result[i] = Outline{.whole = mine.box,
                        .cut = *cut,
                        .truncation = std::clamp(mine.behind > 0 ? by_count : by_area, 0.0, 1.0)};
  }
  return result;
}

/// Share of the rays to the object that nothing stops before.
double visible_share(const RayTracer& tracer, const Projector& projector, const io::ImageBox& box,
                     std::int32_t object) {
  int reached = 0, free = 0;
  for (int row = 0; row < kRaysAcross; ++row) {
    for (int column = 0; column < kRaysAcross; ++column) {
      const Eigen::Vector3d pixel(box.left + (box.right - box.left) * (column + 0.5) / kRaysAcross,
                                  box.top + (box.bottom - box.top) * (row + 0.5) / kRaysAcross,
                                  1.0);
      const Eigen::Vector3d direction = (projector.back * pixel).normalized();
      double from = 0.0;
      Hit hit;
      for (int surface = 0; surface < kMostSurfaces; ++surface) {
        if (!tracer.trace(projector.center, direction, 0.5, from, 200.0, hit)) break;
        if (hit.object == object) {
          ++reached;
          free += surface == 0;
          break;
        }
        from = hit.distance + 1e-3;
      }
    }
  }
  return reached == 0 ? 0.0 : static_cast<double>(free) / reached;
}

int occlusion_level(double visible, const LabelOptions& options) {
  return visible >= options.fully_visible ? 0 : visible >= options.partly_visible ? 1 : 2;
}

io::KittiObject dont_care(const io::ImageBox& box) {
  io::KittiObject area;
  area.type = "DontCare";
  area.left = box.left;
  area.top = box.top;
  area.right = box.right;
  area.bottom = box.bottom;
  return area;
}

}  // namespace

SceneLabels make_labels(const Scene& scene, std::span<const geometry::Box> boxes,
                        const RayTracer& tracer, const CameraView& camera,
                        const LabelOptions& options) {
  validate_options(options, "label options");
  if (boxes.size() != scene.objects.size()) {
    throw InvalidArgument("make_labels: expected " + std::to_string(scene.objects.size()) +
                          " boxes, one an object, got " + std::to_string(boxes.size()));
  }
  const Projector projector = projector_of(camera);
  const auto seen = outlines(scene, projector, camera.image);
  SceneLabels labels;
  std::vector<io::KittiObject> ignored;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    io::KittiObject label = io::to_kitti_object(boxes[i], camera.calibration);
    label.type = object.label;
    label.alpha = io::observation_angle(label);
    const RandomStream random(scene.seed, i, kAnnotator);
    const double height = seen[i] ? seen[i]->cut.bottom - seen[i]->cut.top : 0.0;
    const bool in_reach = seen[i] && std::hypot(label.x, label.z) < options.farthest &&
                          seen[i]->truncation <= options.most_truncated;
    const double visible =
        in_reach ? visible_share(tracer, projector, seen[i]->cut, static_cast<std::int32_t>(i))
                 : 0.0;
    const bool small =
        height < options.least_height ||
        (height < options.small_height && random.uniform(0) > options.small_labelled);
    if (in_reach && visible >= options.least_visible && !small) {
      label.truncation = seen[i]->truncation;
      label.occlusion = label.truncation > 0.0 && random.uniform(1) < options.truncated_unknown
                            ? 3
                            : occlusion_level(visible, options);
      label.left = seen[i]->cut.left;
      label.top = seen[i]->cut.top;
      label.right = seen[i]->cut.right;
      label.bottom = seen[i]->cut.bottom;
      labels.image.push_back(label);
      labels.image_objects.push_back(i);
      continue;
    }
    if (in_reach && visible > 0.03 && height > 9.0 && seen[i]->truncation < 0.5 &&
        random.uniform(2) < options.ignored) {
      ignored.push_back(dont_care(seen[i]->cut));
    }
    label.truncation = 1.0;
    label.occlusion = 3;
    labels.around.push_back(label);
    labels.around_objects.push_back(i);
  }
  labels.image.insert(labels.image.end(), ignored.begin(), ignored.end());
  return labels;
}

io::KittiPlane ground_plane(const Scene& scene, const CameraView& camera) {
  const io::AffineTransform rect = camera.calibration.rect_from_lidar();
  const Eigen::Vector3d normal = rect.linear() * scene.ground_normal;
  return {.normal = normal, .offset = scene.ground_offset - normal.dot(rect.translation())};
}

}  // namespace arbox::simulation
