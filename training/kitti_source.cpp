#include "arbox/training/kitti_source.h"

#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/evaluation/kitti_protocol.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"

namespace arbox::training {
namespace {

io::KittiDataset opened(const KittiSourceOptions& options) {
  validate_options(options, "KITTI scenes");
  return io::KittiDataset::open(options.root);
}

}  // namespace

KittiSceneSource::KittiSceneSource(KittiSourceOptions options, ClassNames classes)
    : options_(std::move(options)), classes_(std::move(classes)), dataset_(opened(options_)) {
  const std::string where = options_.root + ": split " + options_.split;
  if (io::KittiDataset::folder(options_.split) != "training") {
    throw FormatError(where + ": expected frames with labels, got those of the testing folder");
  }
  frames_ = dataset_.frames(options_.split);
  if (frames_.empty()) throw FormatError(where + ": expected frames, got none");
  if (options_.most > 0 && frames_.size() > static_cast<std::size_t>(options_.most)) {
    frames_.resize(options_.most);
  }
}

Scene KittiSceneSource::scene(std::int64_t index) const {
  const std::string& id = frames_.at(static_cast<std::size_t>(index));
  const io::KittiPaths paths = dataset_.paths(options_.split, id);
  io::KittiFrame frame = dataset_.load(options_.split, id);
  Scene result;
  result.source = paths.scan.string();
  std::vector<bool> unseen;
  const auto add = [&](const std::vector<io::KittiObject>& labels, bool hidden) {
    for (const io::KittiObject& label : labels) {
      if (!io::has_box(label)) continue;
      SceneObject& object = result.objects.emplace_back(classes_.object(label.type));
      object.box = io::to_box(label, frame.calibration);
      object.difficulty = evaluation::kitti_difficulty(label);
      unseen.push_back(hidden);
    }
  };
  add(frame.labels, false);
  if (options_.all_round) {
    add(io::read_kitti_labels(dataset_.root() / "training" / "label_360" / (id + ".txt")), true);
    result.cloud = std::move(frame.cloud);
  } else if (frame.image_size) {
    result.cloud = io::crop_to_image(frame.cloud.view(), frame.calibration, *frame.image_size);
  } else {
    throw IoError(paths.image.string() +
                  ": expected the image, whose size decides which points the camera sees, or a "
                  "calibration of one of KITTI's recording days");
  }
  if (frame.plane) result.ground = io::plane_in_lidar(*frame.plane, frame.calibration);
  finish_objects(result, std::move(unseen), options_.min_points);
  return result;
}

}  // namespace arbox::training
