#pragma once

#include <vector>

#include "arbox/geometry/detection.h"
#include "arbox/io/kitti_dataset.h"

namespace arbox::cli {

/// The labels of a frame's objects that the camera does not see: label_360 beside label_2, as
/// 'arbox simulate street' writes it. Throws as io::read_kitti_labels.
std::vector<io::KittiObject> unseen_labels(const io::KittiPaths& paths);

/// The labelled objects of a frame in the LiDAR frame: those that the camera sees (label_2) and,
/// `all_round`, then those that it does not. Throws as the readers of labels and calibration do.
std::vector<geometry::Detection> labelled_objects(const io::KittiPaths& paths, bool all_round);

}  // namespace arbox::cli
