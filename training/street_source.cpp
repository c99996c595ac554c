#include "arbox/training/street_source.h"

#include <utility>

#include "arbox/base/options.h"

namespace arbox::training {

StreetSceneSource::StreetSceneSource(StreetSourceOptions options, ClassNames classes)
    : options_(std::move(options)), classes_(std::move(classes)) {
  validate_options(options_, "street scenes");
}

Scene StreetSceneSource::scene(std::int64_t index) const {
  const auto number = static_cast<std::uint64_t>(options_.first + index);
  const simulation::StreetScan scan =
      simulation::street_scan(options_.scans, options_.seed, number);
  Scene result;
  result.cloud = scan.cloud();
  result.source = "street " + std::to_string(number) + " of seed " + std::to_string(options_.seed);
  for (std::size_t i = 0; i < scan.scene.objects.size(); ++i) {
    SceneObject& added = result.objects.emplace_back(classes_.object(scan.scene.objects[i].label));
    added.box = scan.object_boxes[i];
  }
  result.ground =
      io::KittiPlane{.normal = scan.scene.ground_normal, .offset = scan.scene.ground_offset};
  finish_objects(result, std::vector<bool>(result.objects.size(), true), options_.min_points);
  return result;
}

}  // namespace arbox::training
