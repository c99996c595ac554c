#pragma once

#include <Eigen/Core>

#include "arbox/simulation/kitti_cameras.h"

namespace arbox::simulation {

/// The left colour camera as seen from the LiDAR frame.
struct Projector {
  Eigen::Matrix<double, 3, 4> matrix;  ///< Points to (u w, v w, w).
  Eigen::Vector3d center;              ///< The camera.
  Eigen::Matrix3d back;                ///< Pixels (u, v, 1) to directions, not of unit length.
};

Projector projector_of(const CameraView& camera);

}  // namespace arbox::simulation
