#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/simulation/internal/street_builder.h"

namespace arbox::simulation {
namespace {

constexpr double kFar = 84.0;
constexpr double kPi = std::numbers::pi;

using Scale = Eigen::Vector3d;

/// The turn that makes a front at +y look to the road.
double facing(const RoadSide& side) { return side.sign > 0 ? kPi : 0.0; }

bool built_up(District district) {
  return district == District::kInnerCity || district == District::kResidential ||
         district == District::kCampus;
}

void add_houses(StreetBuilder& builder, const RoadSide& side) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  const bool town = road.district == District::kInnerCity;
  const double chance = built_up(road.district) ? (town ? .95 : .92) : .25;
  double s = -kFar;
  while (s < kFar) {
    const ModelKind kind = town                                 ? ModelKind::kTownHouse
                           : road.district == District::kCampus ? ModelKind::kHall
                                                                : ModelKind::kHouse;
    const double stretch = dice.uniform(.85, 1.2);
    const double length = model(kind, 0).size.x() * stretch;
    const double gap = town && dice.chance(.8) ? 0.0 : dice.uniform(2, 9);
    const double middle = s + .5 * length;
    const bool free = !road.crossing(middle, side.sign > 0, .5 * length);
    if (free && dice.chance(chance)) {
      const double front = side.facade_line() + (town ? 0.0 : dice.uniform(0, 3));
      const double t = front + .5 * model(kind, 0).size.y();
      builder.add_thing(kind, {.s = middle, .t = side.sign * t, .turn = facing(side)},
                        {stretch, 1.0, dice.uniform(.9, 1.1)}, true, .8);
    }
    s += length + gap;
  }
}

enum class Border { kHedge, kWall, kPickets, kMesh, kBushes, kOpen };

Border draw_border(District district, Dice& dice) {
  const double draw = dice.uniform(0, 1);
  if (district == District::kInnerCity) {
    return draw < .30   ? Border::kWall
           : draw < .62 ? Border::kHedge
           : draw < .78 ? Border::kBushes
                        : Border::kOpen;
  }
  if (district == District::kResidential) {
    return draw < .40   ? Border::kHedge
           : draw < .56 ? Border::kWall
           : draw < .66 ? Border::kPickets
           : draw < .72 ? Border::kMesh
           : draw < .92 ? Border::kBushes
                        : Border::kOpen;
  }
  return draw < .22   ? Border::kHedge
         : draw < .28 ? Border::kMesh
         : draw < .76 ? Border::kBushes
                      : Border::kOpen;
}

void add_border_part(StreetBuilder& builder, Border border, const Spot& spot, double height) {
  Dice& dice = builder.dice();
  switch (border) {
    case Border::kHedge:
      builder.add_thing(ModelKind::kHedge, spot, {1.0, 1.0, height});
      break;
    case Border::kWall:
      builder.add_thing(ModelKind::kWall, spot, {1.0, 1.0, height}, true, .1);
      break;
    case Border::kPickets:
      builder.add_thing(ModelKind::kPicketFence, spot);
      break;
    case Border::kMesh:
      builder.add_thing(ModelKind::kMeshFence, spot);
      break;
    case Border::kBushes:
      if (dice.chance(.85)) {
        builder.add_thing(ModelKind::kBush,
                          {spot.s, spot.t + dice.normal(0, .4), dice.uniform(0, 6)},
                          Scale::Constant(dice.uniform(.8, 1.9)));
      }
      break;
    case Border::kOpen:
      break;
  }
}

void add_borders(StreetBuilder& builder, const RoadSide& side) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  if (side.setback < .6) return;
  double s = -kFar;
  while (s < kFar) {
    const Border border = draw_border(road.district, dice);
    const double end = s + dice.uniform(7, 22);
    const double height = dice.chance(.35) ? dice.uniform(.75, 1.3) : dice.uniform(1.3, 2.3);
    for (; s < end; s += 2.0) {
      if (road.crossing(s, side.sign > 0, 1.5)) continue;
      add_border_part(builder, border, {s, side.sign * (side.property_line() + .5), 0.0}, height);
    }
    s += dice.chance(.45) ? dice.uniform(2.5, 4.0) : 0.0;
  }
}

/// Bushes that have grown into each other.
void add_thicket(StreetBuilder& builder, const Spot& spot, double line) {
  Dice& dice = builder.dice();
  const int count = 2 + dice.below(5);
  for (int i = 0; i < count; ++i) {
    Spot place{spot.s + dice.normal(0, 1.3), spot.t + dice.normal(0, .9), dice.uniform(0, 6.2)};
    if (std::abs(place.t) < line + .8) continue;
    const double width = dice.uniform(.7, 1.6);
    builder.add_thing(dice.chance(.8) ? ModelKind::kBush : ModelKind::kConifer, place,
                      {width, width * dice.uniform(.7, 1.3), dice.uniform(.7, 2.1)}, false, .1);
  }
}

void add_gardens(StreetBuilder& builder, const RoadSide& side) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  const double density = road.district == District::kInnerCity ? .3 : 1.0;
  for (double s = -kFar; s < kFar; s += 5.5) {
    if (road.crossing(s, side.sign > 0, 1.0)) continue;
    for (double t = side.property_line() + 1.2; t < side.property_line() + 34; t += 4.5) {
      if (!dice.chance(density * .9)) continue;
      const Spot spot{s + dice.uniform(-2.5, 2.5), side.sign * (t + dice.uniform(-2, 2)),
                      dice.uniform(0, 6.2)};
      if (std::abs(spot.t) < side.property_line() + .9) continue;
      const double draw = dice.uniform(0, 1), size = dice.uniform(.7, 1.5);
      if (draw < .28) {
        add_thicket(builder, spot, side.property_line());
      } else if (draw < .40) {
        builder.add_thing(ModelKind::kBush, spot, Scale::Constant(1.3 * size));
      } else if (draw < .62) {
        builder.add_thing(ModelKind::kConifer, spot, Scale::Constant(size));
      } else if (draw < .85) {
        builder.add_thing(ModelKind::kBroadTree, spot, Scale::Constant(size));
      } else if (draw < .93) {
        builder.add_thing(ModelKind::kTrunk, spot, Scale(size, size, 1));
      } else {
        builder.add_thing(dice.chance(.5) ? ModelKind::kCrate : ModelKind::kBench, spot);
      }
    }
  }
}

void add_woods(StreetBuilder& builder, const RoadSide& side) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  const double chance = dice.uniform(.3, .85);
  const double line = side.property_line() + dice.uniform(.8, 5);
  for (double s = -kFar; s < kFar; s += 3.0) {
    if (road.crossing(s, side.sign > 0, 1.0)) continue;
    for (double t = line; t < line + 18; t += 3.5) {
      if (!dice.chance(chance)) continue;
      const double draw = dice.uniform(0, 1), size = dice.uniform(.7, 1.5);
      const ModelKind kind = draw < .45   ? ModelKind::kBush
                             : draw < .75 ? ModelKind::kBroadTree
                             : draw < .9  ? ModelKind::kTrunk
                                          : ModelKind::kConifer;
      builder.add_thing(kind,
                        {s + dice.uniform(-1.5, 1.5), side.sign * (t + dice.uniform(-1, 1)),
                         dice.uniform(0, 6.2)},
                        Scale::Constant(kind == ModelKind::kBush ? 1.4 * size : size));
    }
  }
}

void add_roadside(StreetBuilder& builder, const RoadSide& side) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  const double line = side.curb_line() + .45;
  const double lamps = dice.uniform(22, 40), trees = dice.chance(.55) ? dice.uniform(6, 14) : 1e9;
  for (double s = -kFar + dice.uniform(0, lamps); s < kFar; s += lamps) {
    if (road.crossing(s, side.sign > 0)) continue;
    builder.add_thing(ModelKind::kStreetLamp, {s, side.sign * line, facing(side)});
  }
  for (double s = -kFar + dice.uniform(0, 8); s < kFar; s += trees) {
    if (!built_up(road.district) || road.crossing(s, side.sign > 0, 3)) continue;
    builder.add_thing(ModelKind::kBroadTree, {s, side.sign * (line + .4), dice.uniform(0, 6.2)},
                      Scale::Constant(dice.uniform(.6, 1.0)));
  }
  constexpr ModelKind kClutter[] = {
      ModelKind::kTrafficSign, ModelKind::kPole,          ModelKind::kBollard,
      ModelKind::kLitterBin,   ModelKind::kWheeledBin,    ModelKind::kSwitchCabinet,
      ModelKind::kCrate,       ModelKind::kParkedBicycle, ModelKind::kTrafficSign,
      ModelKind::kWheeledBin,  ModelKind::kPole};
  const double spacing = road.district == District::kHighway ? 30 : dice.uniform(6, 18);
  for (double s = -kFar + dice.uniform(0, 10); s < kFar; s += spacing * dice.uniform(.4, 1.6)) {
    if (road.crossing(s, side.sign > 0)) continue;
    const ModelKind kind = kClutter[dice.below(11)];
    const bool outer = dice.chance(.5);
    const double t = outer ? side.property_line() - .4 : side.curb_line() + .4;
    const double turn = kind == ModelKind::kTrafficSign ? (dice.chance(.5) ? kPi : 0.0)
                                                        : dice.uniform(-.3, .3) + facing(side);
    builder.add_thing(kind, {s, side.sign * t, turn});
  }
}

void add_rails(StreetBuilder& builder, const RoadSide& side) {
  for (double s = -kFar; s < kFar; s += 4.0) {
    builder.add_thing(ModelKind::kGuardRail, {s, side.sign * (side.curb_line() + .5), facing(side)},
                      Scale::Ones(), false);
  }
}

/// What closes the view along the road and behind the gardens: trees and roofs far away.
void add_horizon(StreetBuilder& builder) {
  Dice& dice = builder.dice();
  const double density = dice.uniform(.8, 1.0);
  const auto add = [&](double s, double t) {
    if (!dice.chance(density)) return;
    const Spot spot{s + dice.normal(0, 3), t + dice.normal(0, 3), dice.uniform(0, 6.2)};
    const double size = dice.uniform(1.3, 2.2);
    builder.add_thing(dice.chance(.7) ? ModelKind::kBroadTree : ModelKind::kConifer, spot,
                      Scale(1.3 * size, 1.3 * size, size), false, .3);
  };
  for (const double end : {-1.0, 1.0}) {
    for (double t = -60; t < 60; t += 5.0) add(end * (std::abs(t) < 14 ? kFar + 8 : 68), t);
    for (double s = -kFar; s < kFar; s += 6.0) add(s, end * 46.0);
  }
}

void add_corners(StreetBuilder& builder) {
  const Road& road = builder.road();
  Dice& dice = builder.dice();
  for (const Crossing& crossing : road.crossings) {
    for (const double sign : {-1.0, 1.0}) {
      const RoadSide& side = road.side(sign);
      for (const double along : {-1.0, 1.0}) {
        if (!dice.chance(.6)) continue;
        const ModelKind kind = road.district == District::kInnerCity && dice.chance(.6)
                                   ? ModelKind::kTrafficLight
                                   : ModelKind::kTrafficSign;
        builder.add_thing(kind, {crossing.s + along * (crossing.half_width + .8),
                                 sign * (side.curb_line() + .6), along > 0 ? 0.0 : kPi});
      }
    }
  }
}

}  // namespace

void add_sides(StreetBuilder& builder) {
  Dice& dice = builder.dice();
  const Road& road = builder.road();
  for (const RoadSide* side : {&road.left, &road.right}) {
    add_houses(builder, *side);
    add_roadside(builder, *side);
    if (road.district == District::kHighway && dice.chance(.6)) add_rails(builder, *side);
    add_borders(builder, *side);
    if (built_up(road.district)) {
      add_gardens(builder, *side);
    } else {
      add_woods(builder, *side);
    }
  }
  add_horizon(builder);
  add_corners(builder);
}

}  // namespace arbox::simulation
