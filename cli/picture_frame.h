#pragma once

#include <Eigen/Core>
#include <vector>

#include "arbox/geometry/detection.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/labeled_scene.h"

namespace arbox::cli {

/// Rotation that brings a frame to one whose z axis is up in pictures: none for `lidar` and `room`;
/// `camera` becomes `room`, or, if the camera looks down into a bin, a frame whose x axis is up in
/// its image and whose z axis comes towards it, so that the view from above shows what it sees.
Eigen::Matrix3d picture_from(io::SceneFrame frame, bool camera_looks_down);

/// Turns the coordinates; channels such as normals stay.
void turn(geometry::PointCloud& cloud, const Eigen::Matrix3d& rotation);
/// Turns the boxes with their quantile boxes, confidence boxes and samples.
void turn(std::vector<geometry::Detection>& detections, const Eigen::Matrix3d& rotation);

}  // namespace arbox::cli
