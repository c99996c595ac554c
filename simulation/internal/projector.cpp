#include "arbox/simulation/internal/projector.h"

namespace arbox::simulation {

Projector projector_of(const CameraView& camera) {
  Projector result;
  const Eigen::Matrix<double, 3, 4> p2 = camera.calibration.p2();
  result.matrix = p2 * camera.calibration.rect_from_lidar().matrix();
  result.back = result.matrix.leftCols<3>().inverse();
  result.center = -result.back * result.matrix.col(3);
  return result;
}

}  // namespace arbox::simulation
