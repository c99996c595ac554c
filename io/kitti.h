#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/detection.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/kitti_object.h"

/// \file
/// The one place where KITTI's camera frame and Arbox' LiDAR frame meet (docs/conventions.md).
///
/// KITTI places a box by the centre of its bottom face in the rectified camera frame and turns it
/// by rotation_y about the camera's y axis, which points down; Arbox by its centre and the yaw
/// about the LiDAR's z axis: yaw = -(rotation_y + pi/2). The small tilt between the two axes is
/// not applied to boxes, as everybody's tools do it; positions are transformed exactly.

namespace arbox::io {

/// The object's box in the LiDAR frame. Throws InvalidArgument if has_box(object) is false.
geometry::Box to_box(const KittiObject& object, const KittiCalibration& calibration);

/// The objects that have a box, in the LiDAR frame, in the order of the file: type becomes the
/// class, the score is the object's (0 in label files).
std::vector<geometry::Detection> to_detections(std::span<const KittiObject> objects,
                                               const KittiCalibration& calibration);

/// The place, sizes and rotation_y of a box in the LiDAR frame, all other fields as in a new
/// KittiObject. Throws InvalidArgument if the box is invalid or its rotation is not about z within
/// 1e-6, since KITTI's files cannot hold it.
KittiObject to_kitti_object(const geometry::Box& box, const KittiCalibration& calibration);

/// The eight corners in the rectified camera frame, those of the bottom face (larger y) first.
std::array<Eigen::Vector3d, 8> rect_corners(const KittiObject& object);

/// A point of the LiDAR frame in the left colour image: column, row (pixels), depth (metres along
/// the camera's axis; points with depth <= 0 are behind the camera and have no place in it).
Eigen::Vector3d project(const Eigen::Vector3d& point, const KittiCalibration& calibration);

/// Edges of an axis-aligned rectangle in an image, pixels.
struct ImageBox {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
};

/// The rectangle around the projected box, before the image's borders cut it. What is nearer than
/// 0.1 m to the camera's plane is cut off first. Nothing if the box is wholly behind that.
std::optional<ImageBox> projected_box(const KittiObject& object,
                                      const KittiCalibration& calibration);

/// The rectangle cut to [0, width - 1] x [0, height - 1]; nothing if no area is left.
std::optional<ImageBox> clipped(const ImageBox& box, const ImageSize& image);

/// The angle under which the camera sees the object: rotation_y - atan2(x, z), in (-pi, pi].
double observation_angle(const KittiObject& object);

/// Result lines of one frame, in the order of the detections.
///
/// With a calibration, boxes go to its camera frame; the 2-D box and alpha are computed, and
/// detections that the left colour image does not show are left out, since the benchmark's labels
/// cover that view only. Truncation and occlusion are -1. Throws as to_kitti_object.
std::vector<KittiObject> to_kitti_results(std::span<const geometry::Detection> detections,
                                          const KittiCalibration& calibration,
                                          const ImageSize& image);

/// Result lines without a calibration: the axes are renamed (x = -y, y = -z, z = x of the LiDAR
/// frame) as if the camera sat in the LiDAR, alpha is -10 and the 2-D box -1 -1 -1 -1. Good for
/// looking at; for scores the camera's calibration is needed.
std::vector<KittiObject> to_kitti_results(std::span<const geometry::Detection> detections);

/// Indices of the points that the left colour image shows: in front of the camera and projected to
/// [0, width) x [0, height). Non-finite points are not. Linear in the points.
std::vector<std::size_t> points_in_image(const geometry::PointCloudView& cloud,
                                         const KittiCalibration& calibration,
                                         const ImageSize& image);

/// Those points with their channels.
geometry::PointCloud crop_to_image(const geometry::PointCloudView& cloud,
                                   const KittiCalibration& calibration, const ImageSize& image);

}  // namespace arbox::io
