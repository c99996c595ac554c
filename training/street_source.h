#pragma once

#include <cstdint>

#include "arbox/base/option_field.h"
#include "arbox/simulation/street_stream.h"
#include "arbox/training/scene_objects.h"

namespace arbox::training {

struct StreetSourceOptions {
  simulation::StreetScanOptions scans;
  std::uint64_t seed = 0;
  /// The first scan, and the number of scans of an epoch. A run that shall never see a scan twice
  /// asks for as many as it has steps times scenes.
  std::int64_t first = 0, scenes = 1000;
  /// Objects with fewer points are left out; the simulator labels those behind houses, too.
  int min_points = 5;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = StreetSourceOptions;
    visitor.group("scans", &Self::scans, "What is simulated");
    visitor.field("seed", &Self::seed, {.help = "Seed of the streets"});
    visitor.field("first", &Self::first, {.help = "Number of the first scan", .low = 0});
    visitor.field("scenes", &Self::scenes,
                  {.help = "Scans of an epoch", .unit = "scenes", .low = 1, .high = 1e9});
    visitor.field("min_points", &Self::min_points,
                  {.help = "Objects with fewer points are left out", .unit = "points", .low = 0});
  }
};

/// Scans straight from the simulator, with the objects of all directions. Nothing is kept: a scan
/// costs about 0.13 s of a processor each time that it is asked for. `arbox simulate street` and
/// KittiSceneSource pay that once.
class StreetSceneSource : public SceneSource {
 public:
  /// Throws ConfigError for options out of range.
  StreetSceneSource(StreetSourceOptions options, ClassNames classes);

  std::int64_t size() const override { return options_.scenes; }
  Scene scene(std::int64_t index) const override;

 private:
  StreetSourceOptions options_;
  ClassNames classes_;
};

}  // namespace arbox::training
