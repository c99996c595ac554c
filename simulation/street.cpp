#include "arbox/simulation/street.h"

#include <algorithm>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/simulation/internal/street_builder.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kStreet = 1;

District draw_district(const StreetOptions& options, Dice& dice) {
  const double weights[] = {options.inner_city, options.residential, options.road, options.campus,
                            options.highway};
  double total = 0.0;
  for (const double weight : weights) total += weight;
  if (!(total > 0.0)) {
    throw ConfigError("street options: expected a district with a weight above 0, all are 0");
  }
  double draw = dice.uniform(0, 1) * total;
  for (int i = 0; i < 5; ++i) {
    draw -= weights[i];
    if (draw < 0.0) return static_cast<District>(i);
  }
  return District::kHighway;
}

Parking draw_parking(District district, Dice& dice) {
  const double draw = dice.uniform(0, 1);
  switch (district) {
    case District::kInnerCity:
      return draw < .45   ? Parking::kParallel
             : draw < .58 ? Parking::kPerpendicular
             : draw < .66 ? Parking::kOblique
                          : Parking::kNone;
    case District::kResidential:
      return draw < .60   ? Parking::kParallel
             : draw < .66 ? Parking::kPerpendicular
             : draw < .72 ? Parking::kOblique
                          : Parking::kNone;
    case District::kCampus:
      return draw < .2 ? Parking::kPerpendicular : Parking::kNone;
    default:
      return draw < .05 ? Parking::kParallel : Parking::kNone;
  }
}

RoadSide draw_side(const Road& road, double sign, Dice& dice) {
  RoadSide side;
  side.sign = sign;
  const int lanes = sign > 0 ? road.lanes_opposite : road.lanes_same - 1;
  side.edge = (0.5 + lanes) * road.lane_width + dice.uniform(-.1, .25);
  side.parking = draw_parking(road.district, dice);
  constexpr double kWidths[] = {0.0, 2.05, 4.4, 5.0};
  side.parking_width = kWidths[static_cast<int>(side.parking)];
  side.curb = dice.uniform(.04, .12);
  switch (road.district) {
    case District::kInnerCity:
      side.pavement = dice.uniform(1.2, 3.0);
      side.setback = dice.chance(.7) ? dice.uniform(.05, .4) : dice.uniform(1, 6);
      break;
    case District::kResidential:
      side.pavement = dice.uniform(.7, 1.7);
      side.verge = dice.chance(.2) ? dice.uniform(.5, 2) : 0.0;
      side.setback = dice.uniform(1.0, 4.5);
      side.bank = dice.normal(.0, .05);
      break;
    case District::kCampus:
      side.pavement = dice.uniform(2, 5);
      side.verge = dice.uniform(0, 4);
      side.setback = dice.uniform(3, 12);
      break;
    case District::kRoad:
      side.curb = dice.chance(.4) ? side.curb : .01;
      side.pavement = dice.chance(.4) ? dice.uniform(1.2, 2.5) : .4;
      side.verge = dice.uniform(.6, 3.5);
      side.setback = dice.uniform(6, 25);
      side.bank = dice.normal(.02, .12);
      break;
    case District::kHighway:
      side.curb = .02;
      side.pavement = .6;
      side.verge = dice.uniform(1, 4);
      side.setback = dice.uniform(15, 40);
      side.bank = dice.normal(.04, .12);
      break;
  }
  return side;
}

void draw_crossings(Road& road, double reach, Dice& dice) {
  const double spacing = road.district == District::kInnerCity     ? 65
                         : road.district == District::kResidential ? 80
                         : road.district == District::kHighway     ? 400
                                                                   : 130;
  double s = -reach + dice.uniform(0, spacing);
  while (s < reach) {
    const int kind = dice.below(4);
    road.crossings.push_back(
        {.s = s, .half_width = dice.uniform(2.6, 4.8), .left = kind != 1, .right = kind != 0});
    s += spacing * dice.uniform(.5, 1.7);
  }
}

Road draw_road(const StreetOptions& options, Dice& dice) {
  Road road;
  road.district = draw_district(options, dice);
  const bool wide = road.district == District::kHighway;
  road.lane_width = wide ? dice.uniform(3.3, 3.7)
                         : dice.uniform(2.5, road.district == District::kRoad ? 3.6 : 3.3);
  road.lanes_same = wide ? 2 : dice.chance(.15) ? 2 : 1;
  road.lanes_opposite = wide ? 2 : dice.chance(.15) ? 0 : dice.chance(.12) ? 2 : 1;
  if (dice.chance(.45)) road.curvature = dice.normal(0, wide ? .0015 : .006);
  road.curvature = std::clamp(road.curvature, -.011, .011);
  road.sensor_height = 1.753 + std::clamp<double>(dice.normal(0, .033), -.07, .1);
  road.slope_x = dice.normal(.0117, .0045);
  road.slope_y = dice.normal(-.009, .018);
  road.vertical_curvature = dice.normal(0, 2.2e-4);
  road.roughness = dice.uniform(.5, 1.6);
  road.left = draw_side(road, 1.0, dice);
  road.right = draw_side(road, -1.0, dice);
  draw_crossings(road, options.reach, dice);
  return road;
}

}  // namespace

Scene street_scene(const StreetOptions& options, std::uint64_t seed, std::uint64_t index) {
  validate_options(options, "street options");
  Dice dice(seed, index, kStreet);
  Scene scene;
  const RandomStream keys(seed, index, kStreet + 1);
  scene.seed = static_cast<std::uint64_t>(keys.bits(0)) << 32 | keys.bits(1);
  Road road = draw_road(options, dice);
  road.seed = scene.seed;
  if (!dice.chance(.2)) {
    scene.ego.speed = options.largest_speed * dice.uniform(0, 1);
    scene.ego.yaw_rate = scene.ego.speed * road.curvature + dice.normal(0, .02);
  }
  scene.ground_normal = Eigen::Vector3d(-road.slope_x, -road.slope_y, 1.0).normalized();
  scene.ground_offset = road.sensor_height * scene.ground_normal.z();
  scene.markings = markings_of(road);
  scene.instances.push_back({.mesh = ground_mesh(road, options.reach),
                             .pose = Eigen::Affine3d::Identity(),
                             .object = -1,
                             .brightness = std::clamp<double>(dice.normal(1, .12), .7, 1.3)});
  StreetBuilder builder(road, dice, scene);
  add_traffic(builder, options);
  add_people(builder, options);
  add_sides(builder);
  return scene;
}

}  // namespace arbox::simulation
