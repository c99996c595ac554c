#include "arbox/cli/labelled_scans.h"

#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"

namespace arbox::cli {

std::vector<geometry::Detection> labelled_objects(const io::KittiPaths& paths, bool all_round) {
  std::filesystem::path labels = paths.label;
  if (all_round) {
    labels = paths.label.parent_path().parent_path() / "label_360" / paths.label.filename();
  }
  return io::to_detections(io::read_kitti_labels(labels),
                           io::read_kitti_calibration(paths.calibration));
}

}  // namespace arbox::cli
