#pragma once

#include "arbox/io/image_size.h"
#include "arbox/io/kitti_calibration.h"

namespace arbox::simulation {

/// A camera beside the scanner: what labels are made for.
struct CameraView {
  io::KittiCalibration calibration;
  io::ImageSize image;
};

/// Different calibrations that the KITTI object benchmark has: one for each recording day.
inline constexpr int kKittiCameraCount = 4;

/// The calibration of day `day` (0..3, most frames first) with the left colour camera's image size,
/// to the digits of docs/simulation.md. P0, P1 and P3 are there because other readers count lines;
/// their baselines are nominal. Throws InvalidArgument for other days.
CameraView kitti_camera(int day);

/// The day of a number in [0, 1), by the days' shares of the training frames.
int kitti_day(double uniform);

}  // namespace arbox::simulation
