#include "arbox/simulation/lidar_model.h"

#include <string>

#include "arbox/base/error.h"

namespace arbox::simulation {

LidarModel spinning_lidar(int beams, double lowest, double highest, int steps) {
  if (beams < 1 || steps < 1 || lowest > highest) {
    throw InvalidArgument(
        "spinning_lidar: expected at least one beam and one step and lowest <= "
        "highest, got " +
        std::to_string(beams) + " beams, " + std::to_string(steps) + " steps, " +
        std::to_string(lowest) + " to " + std::to_string(highest) + " rad");
  }
  LidarModel model;
  model.ticks = steps;
  model.double_step_share = 0.0;
  model.duration = 0.1;
  for (int i = 0; i < beams; ++i) {
    LidarBeam& beam = model.beams.emplace_back();
    beam.elevation = beams == 1 ? highest : highest - i * (highest - lowest) / (beams - 1);
  }
  return model;
}

LidarModel solid_state_lidar(int beams, double lowest, double highest, double width, int columns) {
  constexpr double turn = 6.28318530717958647692;
  if (!(width > 0.0 && width <= turn) || columns < 1) {
    throw InvalidArgument(
        "solid_state_lidar: expected a width in (0, 2 pi] and at least one "
        "column, got " +
        std::to_string(width) + " rad and " + std::to_string(columns) + " columns");
  }
  LidarModel model =
      spinning_lidar(beams, lowest, highest, static_cast<int>(columns * turn / width + 0.5));
  model.half_field_of_view = 0.5 * width;
  return model;
}

}  // namespace arbox::simulation
