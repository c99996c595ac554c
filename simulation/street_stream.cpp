#include "arbox/simulation/street_stream.h"

#include "arbox/base/options.h"
#include "arbox/base/random.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kCamera = 300;

/// Calls use(index) for the objects in view, or for all.
template <class Use>
void for_objects(const StreetScan& scan, bool all_round, const Use& use) {
  if (all_round) {
    for (std::size_t i = 0; i < scan.scene.objects.size(); ++i) use(i);
  } else {
    for (const std::size_t i : scan.labels.image_objects) use(i);
  }
}

}  // namespace

std::vector<geometry::Box> StreetScan::boxes(bool all_round) const {
  std::vector<geometry::Box> result;
  for_objects(*this, all_round, [&](std::size_t i) { result.push_back(object_boxes[i]); });
  return result;
}

std::vector<std::string> StreetScan::classes(bool all_round) const {
  std::vector<std::string> result;
  for_objects(*this, all_round, [&](std::size_t i) { result.push_back(scene.objects[i].label); });
  return result;
}

StreetScan street_scan(const StreetScanOptions& options, std::uint64_t seed, std::uint64_t index) {
  validate_options(options, "street scan options");
  StreetScan result;
  result.scene = street_scene(options.street, seed, index);
  const LidarModel lidar = make_lidar(options.lidar);
  const RayTracer tracer(result.scene, lidar.duration);
  const LidarOptions scanning{.motion_compensated = options.motion_compensated, .ideal = false};
  result.returns = scan(result.scene, tracer, lidar, scanning);
  result.object_boxes = scanned_boxes(result.scene, lidar, scanning);
  const int day = options.camera >= 0 ? options.camera
                                      : kitti_day(RandomStream(seed, index, kCamera).uniform(0));
  result.camera = kitti_camera(day);
  result.labels =
      make_labels(result.scene, result.object_boxes, tracer, result.camera, options.labels);
  return result;
}

StreetScan StreetStream::next() {
  const std::uint64_t index = next_;
  next_ += step_;
  return street_scan(options_, seed_, index);
}

}  // namespace arbox::simulation
