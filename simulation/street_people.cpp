#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/simulation/internal/street_builder.h"

namespace arbox::simulation {
namespace {

constexpr double kPi = std::numbers::pi;

double draw_heading(Dice& dice) {
  const double draw = dice.uniform(0, 1);
  if (draw < .25) return dice.normal(0, .2);
  if (draw < .50) return kPi + dice.normal(0, .2);
  if (draw < .64) return .5 * kPi + dice.normal(0, .2);
  if (draw < .76) return -.5 * kPi + dice.normal(0, .2);
  return dice.uniform(-kPi, kPi);
}

/// A place on a pavement, sometimes on the road.
double draw_across(const Road& road, const RoadSide& side, Dice& dice) {
  const double inner = side.curb_line() + .3, outer = std::max(inner + .5, side.property_line());
  const bool open = road.district == District::kCampus || road.district == District::kInnerCity;
  if (dice.chance(open ? .30 : .12)) return side.sign * dice.uniform(1.0, inner);
  return side.sign *
         dice.uniform(
             inner, open ? std::min(outer + 2.0, std::max(outer, side.facade_line() - .5)) : outer);
}

void add_walkers(StreetBuilder& builder, double expected) {
  Dice& dice = builder.dice();
  const Road& road = builder.road();
  // Most streets are empty of walkers, and the others are not.
  if (!dice.chance(.55)) return;
  double left = 1.4 * expected;
  while (left > 0.0 && dice.chance(std::min(1.0, left))) {
    left -= 1.0;
    const double s = dice.chance(.14) ? dice.normal(28, 26) : dice.normal(4, 12.5);
    const RoadSide& side = dice.chance(.5) ? road.left : road.right;
    const Spot spot{.s = s, .t = draw_across(road, side, dice), .turn = draw_heading(dice)};
    const double speed = dice.chance(.7) ? dice.uniform(.7, 1.6) : 0.0;
    builder.add_person("Pedestrian", spot, speed);
    if (dice.chance(.35)) {
      builder.add_person("Pedestrian",
                         {.s = s + dice.normal(0, .25),
                          .t = spot.t + (dice.chance(.5) ? 1 : -1) * dice.uniform(.7, 1.0),
                          .turn = spot.turn + dice.normal(0, .15)},
                         speed);
      left -= 1.0;
    }
  }
}

void add_riders(StreetBuilder& builder, double expected) {
  Dice& dice = builder.dice();
  const Road& road = builder.road();
  while (expected > 0.0 && dice.chance(std::min(1.0, expected))) {
    expected -= 1.0;
    const RoadSide& side = dice.chance(.45) ? road.left : road.right;
    const double t = dice.chance(.6) ? side.edge - dice.uniform(.3, 1.0)
                                     : side.curb_line() + dice.uniform(.2, 1.5);
    const double along = (side.sign > 0) == dice.chance(.8) ? kPi : 0.0;
    const double turn = dice.chance(.8) ? along + dice.normal(0, .12) : dice.uniform(-kPi, kPi);
    builder.add_person("Cyclist", {.s = dice.normal(10, 26), .t = side.sign * t, .turn = turn},
                       dice.chance(.85) ? dice.uniform(2.5, 6) : 0.0);
  }
}

void add_sitting(StreetBuilder& builder) {
  Dice& dice = builder.dice();
  const Road& road = builder.road();
  const RoadSide& side = dice.chance(.58) ? road.left : road.right;
  const double s = dice.normal(11, 6), t = side.sign * (side.property_line() - .4);
  const int count = 1 + dice.below(6);
  for (int i = 0; i < count; ++i) {
    builder.add_person("Person_sitting",
                       {.s = s + .9 * i, .t = t + dice.normal(0, .5), .turn = draw_heading(dice)},
                       0.0);
  }
}

}  // namespace

void add_people(StreetBuilder& builder, const StreetOptions& options) {
  Dice& dice = builder.dice();
  const District district = builder.road().district;
  const bool open = district == District::kCampus || district == District::kInnerCity;
  const double quiet = district == District::kHighway ? .1 : district == District::kRoad ? .3 : .9;
  const double usual = open ? 3.6 : quiet;
  add_walkers(builder, options.people * usual * std::exp(dice.normal(-.2, 1.15)));
  const double riders = district == District::kHighway ? .03 : open ? .9 : .34;
  add_riders(builder, options.people * riders * std::exp(dice.normal(-.2, .7)));
  if (dice.chance(std::min(1.0, options.people * (open ? .045 : .0035)))) add_sitting(builder);
}

}  // namespace arbox::simulation
