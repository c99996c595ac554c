#pragma once

#include <vector>

#include "arbox/geometry/detection.h"
#include "arbox/io/kitti_dataset.h"

namespace arbox::cli {

/// The labelled objects of a frame in the LiDAR frame: those of label_2, which the camera sees, or,
/// `all_round`, those of label_360 beside it, as 'arbox simulate street' writes them. Throws as the
/// readers of labels and calibration do.
std::vector<geometry::Detection> labelled_objects(const io::KittiPaths& paths, bool all_round);

}  // namespace arbox::cli
