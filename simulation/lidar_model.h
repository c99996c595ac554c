#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace arbox::simulation {

/// Azimuths, radians in [0, 2 pi), at which a part of the own vehicle returns a pulse.
struct OwnReturn {
  double begin = 0.0, end = 0.0;
  double chance = 1.0;               ///< Of a pulse to come back from there.
  double range = 1.5, spread = 0.0;  ///< Mean and standard deviation, metres.
};

/// One laser of a spinning scanner. With elevation v, offsets V, h and c, a return at distance d
/// and encoder angle e lies at
///
///     xy = d cos v - V sin v            theta = e + c
///     x = xy cos theta - h sin theta    y = xy sin theta + h cos theta    z = d sin v + V cos v
struct LidarBeam {
  double elevation = 0.0;          ///< v, radians above the horizon.
  double vertical_offset = 0.0;    ///< V, metres.
  double horizontal_offset = 0.0;  ///< h, metres.
  double azimuth_offset = 0.0;     ///< c, radians.
  double range_bias = 0.0;         ///< Added to every range, metres.
  double gain = 1.0;               ///< Multiplies reported intensities.
  /// Azimuths that the own vehicle hides, radians in [0, 2 pi), (begin, end).
  std::vector<std::pair<double, double>> hidden;
  /// What the own vehicle returns, with intensity 0; it hides what is behind.
  std::vector<OwnReturn> own;
};

/// A spinning multi-beam scanner: geometry, timing, noise and what it reports.
struct LidarModel {
  /// Best elevation first: the order of rings in a scan.
  std::vector<LidarBeam> beams;
  /// Encoder ticks of a revolution, and the share of firings that come two ticks (not one) after
  /// the one before.
  int ticks = 4000;
  double double_step_share = 0.855;
  /// Seconds of a revolution. The head turns clockwise from azimuth +180 degrees; it looks forward
  /// half-way, which is the reference time.
  double duration = 0.1035;
  /// Azimuths that are seen, radians either side of forward (pi: all round).
  double half_field_of_view = 3.14159265358979323846;
  double nearest = 1.3, farthest = 80.0;  ///< Metres.
  double range_step = 0.002;              ///< Metres; 0 for none.
  double coordinate_step = 0.001;         ///< Metres; 0 for none.
  double intensity_step = 0.01;
  double intensity_limit = 0.99;
  /// Standard deviation of a range, metres, at 0 m and its growth a metre.
  double range_noise = 0.006, range_noise_growth = 0.0002;
  /// Chance that a return is lost although the surface is good, at 0 m and its growth a metre.
  double dropout = 0.0008, dropout_growth = 0.00025;
  /// Signal (reflectivity * cosine / range^2, range in metres) at which half of the returns are
  /// lost, and how sharply.
  double half_signal = 3.8e-6, signal_sharpness = 3.5;
  /// Chance that a return is displaced to a longer range (reflections).
  double spurious = 0.002;
};

/// The 64-beam scanner of the KITTI recordings (Velodyne HDL-64E): the calibration measured from
/// its published scans, exact to the rounding of the files (docs/simulation.md).
LidarModel hdl64();

/// `beams` evenly spaced elevations (radians) without offsets, and `steps` firings a revolution:
/// other scanners, for instance 16 beams over +-15 degrees.
LidarModel spinning_lidar(int beams, double lowest, double highest, int steps);

/// A forward-looking scanner of `beams` rows over a field of view of `width` radians.
LidarModel solid_state_lidar(int beams, double lowest, double highest, double width, int columns);

}  // namespace arbox::simulation
