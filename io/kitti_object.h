#pragma once

#include <string>

/// \file
/// One line of a KITTI object label or result file, kept in the file's own numbers (rectified
/// camera frame). io/kitti.h converts to and from boxes in the LiDAR frame.

namespace arbox::io {

struct KittiObject {
  std::string type;
  /// Share of the object outside of the image, 0..1; -1 for DontCare and results.
  double truncation = -1.0;
  /// 0 visible, 1 partly, 2 largely occluded, 3 unknown; -1 for DontCare and results.
  int occlusion = -1;
  /// Observation angle, radians; -10 if unknown.
  double alpha = -10.0;
  /// 2-D box in the left colour image, pixels: left, top, right, bottom.
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
  /// Full sizes, metres.
  double height = -1.0, width = -1.0, length = -1.0;
  /// Centre of the bottom face in the rectified camera frame, metres (x right, y down, z forward).
  double x = -1000.0, y = -1000.0, z = -1000.0;
  /// Rotation about the camera's y axis, radians.
  double rotation_y = -10.0;
  /// Confidence; only result files have it.
  double score = 0.0;
};

}  // namespace arbox::io
