#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/simulation/internal/street_builder.h"

namespace arbox::simulation {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFar = 82.0;

std::string draw_moving(District district, Dice& dice) {
  const bool large = district == District::kHighway || district == District::kRoad;
  const double draw = dice.uniform(0, 1);
  if (draw < .85) return "Car";
  if (draw < (large ? .91 : .915)) return "Van";
  if (draw < (large ? .97 : .948)) return "Truck";
  return draw < (large ? .985 : .967) ? "Misc" : "Car";
}

std::string draw_parked(Dice& dice) {
  const double draw = dice.uniform(0, 1);
  return draw < .915 ? "Car" : draw < .962 ? "Van" : draw < .975 ? "Truck" : "Misc";
}

double usual_speed(District district) {
  switch (district) {
    case District::kHighway:
      return 20.0;
    case District::kRoad:
      return 15.0;
    case District::kCampus:
      return 5.0;
    default:
      return 9.0;
  }
}

/// Vehicles one after the other; `mean_gap` metres between bumpers.
void fill_lane(StreetBuilder& builder, double t, bool same, double mean_gap) {
  Dice& dice = builder.dice();
  const double usual = usual_speed(builder.road().district);
  const bool queue = mean_gap < 9.0;
  double s = -kFar - mean_gap * std::log(1 - dice.uniform(0, 1));
  while (s < kFar) {
    const double speed = queue ? 0.0 : usual * dice.uniform(.5, 1.2);
    const double turn = (same ? 0.0 : kPi) + dice.normal(0, .03);
    builder.add_vehicle(draw_moving(builder.road().district, dice),
                        {.s = s, .t = t + dice.normal(0, .22), .turn = turn}, speed);
    s += 6.5 - mean_gap * std::log(1 - dice.uniform(0, 1));
  }
}

void fill_lanes(StreetBuilder& builder, double factor) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  double mean_gap = 66.0 * std::exp(dice.normal(0, .9));
  if (road.district == District::kHighway) mean_gap *= .65;
  if (road.district == District::kCampus) mean_gap *= 4.0;
  if (dice.chance(.04)) mean_gap = 5.0;
  mean_gap = std::max(2.5, mean_gap / std::max(1e-3, factor));
  if (factor <= 0.0) return;
  for (int lane = 0; lane < road.lanes_same; ++lane) {
    fill_lane(builder, -lane * road.lane_width, true, mean_gap * dice.uniform(.7, 2.2));
  }
  for (int lane = 1; lane <= road.lanes_opposite; ++lane) {
    fill_lane(builder, lane * road.lane_width, false, mean_gap * dice.uniform(.6, 1.8));
  }
}

void park_along(StreetBuilder& builder, const RoadSide& side, double share) {
  Dice& dice = builder.dice();
  const Road& road = builder.road();
  const bool left = side.sign > 0;
  const bool against = left && dice.chance(.25);
  const double along = left && !against ? kPi : 0.0;
  double s = -kFar - dice.uniform(0, 6);
  while (s < kFar) {
    const bool parallel = side.parking == Parking::kParallel;
    const double pitch = parallel ? dice.uniform(5.0, 6.6) : dice.uniform(2.45, 2.9);
    const bool stays_clear = road.crossing(s, left, 3.5) != nullptr;
    if (!stays_clear && dice.chance(share)) {
      double turn = along + dice.normal(0, .03);
      if (!parallel) {
        const double angle = side.parking == Parking::kOblique ? .9 : 1.5708;
        turn = (dice.chance(.7) ? side.sign : -side.sign) * angle + dice.normal(0, .04);
      } else if (dice.chance(.12)) {
        turn += kPi;
      }
      const double middle = side.edge + .5 * side.parking_width + dice.normal(0, .1);
      builder.add_vehicle(draw_parked(dice), {.s = s, .t = side.sign * middle, .turn = turn}, 0.0);
    }
    s += pitch;
  }
}

void park_in_drives(StreetBuilder& builder, const RoadSide& side, double factor) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  if (road.district == District::kHighway) return;
  const double chance = factor * (road.district == District::kResidential ? .20 : .10);
  for (double s = -kFar; s < kFar; s += 11.0) {
    if (!dice.chance(std::min(1.0, chance)) || road.crossing(s, side.sign > 0, 3.0)) continue;
    const double t = side.property_line() + dice.uniform(2.4, 12.0);
    if (t > side.facade_line() - 2.4) continue;
    const double turn = dice.chance(.75) ? (dice.chance(.5) ? .5 : -.5) * kPi + dice.normal(0, .12)
                                         : dice.uniform(-kPi, kPi);
    builder.add_vehicle(draw_parked(dice),
                        {.s = s + dice.uniform(-3, 3), .t = side.sign * t, .turn = turn}, 0.0);
  }
}

void fill_crossings(StreetBuilder& builder, double factor) {
  Dice& dice = builder.dice();
  for (const Crossing& crossing : builder.road().crossings) {
    for (const double sign : {-1.0, 1.0}) {
      if (!(sign > 0 ? crossing.left : crossing.right)) continue;
      const RoadSide& side = builder.road().side(sign);
      for (double t = side.curb_line() + 3.0; t < 60; t += 7.0) {
        for (const double lane : {-1.0, 1.0}) {
          if (!dice.chance(std::min(1.0, .085 * factor))) continue;
          const double outward = lane * sign < 0 ? sign : -sign;
          builder.add_vehicle(draw_moving(builder.road().district, dice),
                              {.s = crossing.s + lane * .5 * crossing.half_width,
                               .t = sign * (t + dice.uniform(0, 2)),
                               .turn = outward * .5 * kPi + dice.normal(0, .06)},
                              dice.chance(.4) ? 0.0 : 5.0);
        }
      }
    }
  }
}

void add_tram(StreetBuilder& builder) {
  Dice& dice = builder.dice();
  const Road& road = builder.road();
  const bool in_town = road.district == District::kInnerCity || road.district == District::kCampus;
  if (!dice.chance(in_town ? .24 : .03)) return;
  const RoadSide& side = dice.chance(.7) ? road.left : road.right;
  const double track = side.property_line() + 1.8;
  const bool own_track = track < side.facade_line() - 2.0;
  const double t = own_track                 ? side.sign * track
                   : road.lanes_opposite > 0 ? road.lane_width
                                             : side.sign * (side.edge + 1.5);
  builder.add_vehicle("Tram",
                      {.s = dice.uniform(-60, 75), .t = t, .turn = dice.chance(.5) ? 0.0 : kPi},
                      dice.chance(.4) ? 0.0 : 8.0);
}

}  // namespace

void add_traffic(StreetBuilder& builder, const StreetOptions& options) {
  Dice& dice = builder.dice();
  add_tram(builder);
  for (const RoadSide* side : {&builder.road().left, &builder.road().right}) {
    const double share = std::min(
        1.0, options.parked * std::pow(dice.uniform(.05, .95), side->sign > 0 ? 1.6 : 2.2));
    if (side->parking != Parking::kNone) park_along(builder, *side, share);
    park_in_drives(builder, *side, options.parked);
  }
  fill_lanes(builder, options.traffic);
  fill_crossings(builder, options.traffic);
}

}  // namespace arbox::simulation
