#pragma once

#include "arbox/base/option_field.h"
#include "arbox/simulation/lidar_model.h"

namespace arbox::simulation {

enum class LidarKind { kHdl64, kSpinning16, kSpinning32, kSpinning128, kSolidState };

/// The scanner of a kind: the KITTI recordings' HDL-64E; 16 beams over -15..15 degrees, 32 over
/// -30.67..10.67, 128 over -25..15, each every 0.2 degrees (0.1 with 128 beams); a forward-looking
/// scanner of 120 x 25 degrees with 64 rows.
LidarModel make_lidar(LidarKind kind);

}  // namespace arbox::simulation
