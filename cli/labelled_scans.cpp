#include "arbox/cli/labelled_scans.h"

#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"

namespace arbox::cli {

std::vector<io::KittiObject> unseen_labels(const io::KittiPaths& paths) {
  const std::filesystem::path root = paths.label.parent_path().parent_path();
  return io::read_kitti_labels(root / "label_360" / paths.label.filename());
}

std::vector<geometry::Detection> labelled_objects(const io::KittiPaths& paths, bool all_round) {
  auto labels = io::read_kitti_labels(paths.label);
  if (all_round) {
    const auto unseen = unseen_labels(paths);
    labels.insert(labels.end(), unseen.begin(), unseen.end());
  }
  return io::to_detections(labels, io::read_kitti_calibration(paths.calibration));
}

}  // namespace arbox::cli
