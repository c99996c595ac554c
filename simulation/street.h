#pragma once

#include <cstdint>

#include "arbox/base/option_field.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// What streets look like. The defaults are tuned to the scans and labels of the KITTI object
/// benchmark (docs/simulation.md).
struct StreetOptions {
  /// How often each kind of district comes; only their ratios matter.
  double inner_city = 0.18, residential = 0.50, road = 0.16, campus = 0.08, highway = 0.08;
  /// Multiply the usual numbers of vehicles on the road, parked vehicles, and persons and cyclists.
  double traffic = 1.0, parked = 1.0, people = 1.0;
  /// The own vehicle's speed is drawn up to here; a fifth of the scenes stand.
  double largest_speed = 15.0;
  /// Metres of street before and behind the own vehicle.
  double reach = 90.0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    const auto weight = [&](std::string_view name, double StreetOptions::*member,
                            std::string_view help) {
      visitor.field(name, member, {.help = help, .low = 0.0, .high = 1e6});
    };
    weight("inner_city", &StreetOptions::inner_city, "Weight of inner-city streets");
    weight("residential", &StreetOptions::residential, "Weight of residential streets");
    weight("road", &StreetOptions::road, "Weight of country roads");
    weight("campus", &StreetOptions::campus, "Weight of campus and pedestrian areas");
    weight("highway", &StreetOptions::highway, "Weight of roads with several lanes");
    const auto factor = [&](std::string_view name, double StreetOptions::*member,
                            std::string_view help) {
      visitor.field(name, member, {.help = help, .low = 0.0, .high = 10.0});
    };
    factor("traffic", &StreetOptions::traffic, "Multiplies the vehicles on the road");
    factor("parked", &StreetOptions::parked, "Multiplies the parked vehicles");
    factor("people", &StreetOptions::people, "Multiplies persons and cyclists");
    visitor.field("largest_speed", &StreetOptions::largest_speed,
                  {.help = "The own vehicle's largest speed", .unit = "m/s", .low = 0, .high = 60});
    visitor.field(
        "reach", &StreetOptions::reach,
        {.help = "Street before and behind the own vehicle", .unit = "m", .low = 20, .high = 200});
  }
};

/// Scene number `index` of the streets with this seed. Depends on nothing else; about 20 ms.
/// Throws ConfigError for options out of range or when all district weights are 0.
Scene street_scene(const StreetOptions& options, std::uint64_t seed, std::uint64_t index);

}  // namespace arbox::simulation
