#pragma once

#include <string>

/// \file
/// A calibration in KITTI's layout with made numbers: R0_rect turns by asin(0.28) about the
/// camera's y axis, Tr_velo_to_cam renames the axes and shifts, all exactly orthonormal.

namespace arbox::testing {

inline const std::string kMadeCalibration =
    "P0: 700 0 600 0 0 700 180 0 0 0 1 0\n"
    "P1: 700 0 600 -350 0 700 180 0 0 0 1 0\n"
    "P2: 700 0 600 40 0 700 180 0.5 0 0 1 0.005\n"
    "P3: 700 0 600 -320 0 700 180 2 0 0 1 0.003\n"
    "R0_rect: 0.96 0 0.28 0 1 0 -0.28 0 0.96\n"
    "Tr_velo_to_cam: 0 -1 0 0.01 0 0 -1 -0.08 1 0 0 -0.27\n"
    "Tr_imu_to_velo: 1 0 0 -0.8 0 1 0 0.3 0 0 1 -0.8\n";

}  // namespace arbox::testing
