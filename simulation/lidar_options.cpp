#include "arbox/simulation/lidar_options.h"

#include <numbers>

#include "arbox/base/error.h"

namespace arbox::simulation {

LidarModel make_lidar(LidarKind kind) {
  constexpr double degree = std::numbers::pi / 180.0;
  switch (kind) {
    case LidarKind::kHdl64:
      return hdl64();
    case LidarKind::kSpinning16:
      return spinning_lidar(16, -15.0 * degree, 15.0 * degree, 1800);
    case LidarKind::kSpinning32:
      return spinning_lidar(32, -30.67 * degree, 10.67 * degree, 1800);
    case LidarKind::kSpinning128:
      return spinning_lidar(128, -25.0 * degree, 15.0 * degree, 3600);
    case LidarKind::kSolidState:
      return solid_state_lidar(64, -16.0 * degree, 9.0 * degree, 120.0 * degree, 800);
  }
  throw InvalidArgument("make_lidar: unknown kind of scanner");
}

}  // namespace arbox::simulation
