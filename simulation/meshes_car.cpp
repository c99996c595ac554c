#include <algorithm>
#include <vector>

#include "arbox/simulation/internal/model_builders.h"
#include "arbox/simulation/internal/vehicle_parts.h"

namespace arbox::simulation {
namespace {

struct CarShape {
  float length, width, height;
  float bottom, bonnet, shoulder;     // heights, metres
  float cowl, roof_front, roof_rear;  // from the front, share of the length
  float deck;                         // share of the length where the boot's deck begins; 1: none
  float wheel;
};

CarShape shape_of(ModelKind kind, Dice& dice) {
  const auto about = [&](double value, double part) {
    return dice.uniform(value * (1 - part), value * (1 + part));
  };
  switch (kind) {
    case ModelKind::kSmallCar:
      return {.length = about(3.45, .05),
              .width = 1.60f,
              .height = about(1.49, .02),
              .bottom = .19f,
              .bonnet = about(.93, .03),
              .shoulder = about(.93, .02),
              .cowl = about(.26, .06),
              .roof_front = .455f,
              .roof_rear = about(.90, .015),
              .deck = 1.0f,
              .wheel = .285f};
    case ModelKind::kSedan:
      return {.length = about(4.40, .05),
              .width = 1.72f,
              .height = about(1.43, .02),
              .bottom = .18f,
              .bonnet = about(.89, .03),
              .shoulder = about(.92, .02),
              .cowl = about(.30, .05),
              .roof_front = .46f,
              .roof_rear = about(.74, .02),
              .deck = .87f,
              .wheel = .31f};
    case ModelKind::kEstate:
      return {.length = about(4.50, .04),
              .width = 1.73f,
              .height = about(1.46, .02),
              .bottom = .18f,
              .bonnet = about(.90, .03),
              .shoulder = about(.93, .02),
              .cowl = about(.29, .05),
              .roof_front = .445f,
              .roof_rear = about(.895, .02),
              .deck = 1.0f,
              .wheel = .31f};
    case ModelKind::kSuv:
      return {.length = about(4.40, .05),
              .width = 1.80f,
              .height = about(1.70, .02),
              .bottom = .27f,
              .bonnet = about(1.06, .03),
              .shoulder = about(1.07, .02),
              .cowl = about(.27, .05),
              .roof_front = .43f,
              .roof_rear = about(.88, .02),
              .deck = 1.0f,
              .wheel = .36f};
    case ModelKind::kMinivan:
      return {.length = about(4.35, .05),
              .width = 1.74f,
              .height = about(1.66, .02),
              .bottom = .20f,
              .bonnet = about(1.00, .03),
              .shoulder = about(1.01, .02),
              .cowl = about(.21, .06),
              .roof_front = .385f,
              .roof_rear = about(.895, .02),
              .deck = 1.0f,
              .wheel = .31f};
    case ModelKind::kPanelVan:
      return {.length = about(5.10, .08),
              .width = 1.92f,
              .height = about(2.25, .08),
              .bottom = .22f,
              .bonnet = about(1.10, .03),
              .shoulder = about(1.2, .02),
              .cowl = about(.14, .10),
              .roof_front = .25f,
              .roof_rear = about(.985, .005),
              .deck = 1.0f,
              .wheel = .34f};
    case ModelKind::kMinibus:
      return {.length = about(4.80, .05),
              .width = 1.88f,
              .height = about(1.95, .03),
              .bottom = .22f,
              .bonnet = about(1.06, .03),
              .shoulder = about(1.12, .02),
              .cowl = about(.15, .10),
              .roof_front = .28f,
              .roof_rear = about(.97, .01),
              .deck = 1.0f,
              .wheel = .33f};
    default:
      return {.length = about(3.95, .05),
              .width = 1.67f,
              .height = about(1.47, .02),
              .bottom = .18f,
              .bonnet = about(.91, .03),
              .shoulder = about(.925, .02),
              .cowl = about(.27, .06),
              .roof_front = .45f,
              .roof_rear = about(.865, .02),
              .deck = 1.0f,
              .wheel = .30f};
  }
}

/// The foremost part of a car is the lip of its bumper, the rearmost the bumper's middle; both run
/// back towards the corners by as much as the scans of real cars show within their boxes.
std::vector<Station> front_of(const CarShape& car) {
  const auto x = [&](float metres) { return 0.5f * car.length - metres; };
  const float half = 0.5f * car.width, cowl = car.cowl * car.length;
  constexpr Material kPaint = Material::kPaintLight;
  return {{x(0), car.bottom + .08f, car.bottom + .11f, car.bottom + .12f, .22f * half, .20f * half,
           kPaint, kPaint},
          {x(.05f), car.bottom + .05f, car.bottom + .16f, car.bottom + .17f, .42f * half,
           .38f * half, kPaint, kPaint},
          {x(.10f), car.bottom + .04f, .52f * car.bonnet, .54f * car.bonnet, .54f * half,
           .45f * half, kPaint, kPaint},
          {x(.21f), car.bottom + .02f, .66f * car.bonnet, .68f * car.bonnet, .74f * half,
           .64f * half, kPaint, kPaint},
          {x(std::min(.40f, .55f * cowl)), car.bottom, car.bonnet - .20f, car.bonnet - .16f,
           .91f * half, .77f * half, kPaint, kPaint},
          {x(std::min(.65f, .80f * cowl)), car.bottom, car.bonnet - .10f, car.bonnet - .06f, half,
           .84f * half, kPaint, kPaint}};
}

/// From behind the roof, or the boot's deck, whose end stands `depth` before the car's and is `top`
/// high.
void add_rear(std::vector<Station>& list, const CarShape& car, float depth, float top,
              Material cover) {
  const auto x = [&](float metres) { return metres - 0.5f * car.length; };
  const float half = 0.5f * car.width;
  const float sill = car.shoulder + std::min(.08f, .5f * (top - car.shoulder));
  const float edge = std::min(.13f, .6f * depth), face = std::min(.07f, .3f * depth);
  constexpr Material kPaint = Material::kPaintLight;
  if (depth > .36f) {
    const float share = (.30f - edge) / (depth - edge);
    list.push_back({x(.30f), car.bottom, car.shoulder - .01f, sill + share * (top - sill),
                    .95f * half, .70f * half, kPaint, cover});
  }
  list.push_back({x(edge), car.bottom + .02f, car.shoulder - .03f, sill, .84f * half, .70f * half,
                  kPaint, kPaint});
  list.push_back({x(face), car.bottom + .05f, .68f * car.shoulder, .70f * car.shoulder, .66f * half,
                  .58f * half, kPaint, kPaint});
  list.push_back({x(.4f * face), .46f * car.shoulder, .62f * car.shoulder, .63f * car.shoulder,
                  .50f * half, .45f * half, kPaint, kPaint});
  list.push_back({x(0), .52f * car.shoulder, .56f * car.shoulder, .57f * car.shoulder, .25f * half,
                  .22f * half, kPaint, kPaint});
}

std::vector<Station> stations_of(const CarShape& car, bool side_windows, bool rear_window) {
  const auto x = [&](float share) { return car.length * (0.5f - share); };
  const float half = 0.5f * car.width, roof = car.height - 0.045f, roof_half = 0.70f * half;
  const Material window = side_windows ? Material::kGlass : Material::kPaintLight;
  const Material rear = rear_window ? Material::kGlass : Material::kPaintLight;
  constexpr Material kPaint = Material::kPaintLight;
  std::vector<Station> list = front_of(car);
  list.push_back({x(car.cowl), car.bottom, car.shoulder - .03f, car.bonnet + .07f, half,
                  .84f * half, window, Material::kGlass});
  list.push_back(
      {x(car.roof_front), car.bottom, car.shoulder, roof - .13f, half, roof_half, window, kPaint});
  const float first = car.roof_front, last = car.roof_rear;
  const auto pillar = [&](float share) {
    list.push_back(
        {x(share - .008f), car.bottom, car.shoulder, roof, half, roof_half, kPaint, kPaint});
    list.push_back(
        {x(share + .012f), car.bottom, car.shoulder, roof, half, roof_half, window, kPaint});
  };
  pillar(first + .38f * (last - first));
  pillar(first + .78f * (last - first));
  list.push_back(
      {x(last - .04f), car.bottom, car.shoulder, roof - .08f, half, roof_half, kPaint, kPaint});
  list.push_back({x(last), car.bottom, car.shoulder + .01f, roof - .13f, half, .97f * roof_half,
                  kPaint, rear});
  if (car.deck < 1.0f) {
    list.push_back({x(car.deck), car.bottom, car.shoulder, car.shoulder + .06f, half, .82f * half,
                    kPaint, kPaint});
    add_rear(list, car, (1 - car.deck) * car.length, car.shoulder + .06f, kPaint);
  } else {
    add_rear(list, car, (1 - last) * car.length, roof - .13f, rear);
  }
  return list;
}

void add_lamps_and_plates(MeshBuilder& body, const CarShape& car) {
  const float front = 0.5f * car.length, half = 0.5f * car.width;
  for (const float sign : {-1.0f, 1.0f}) {
    const float y = sign * 0.74f * half;
    body.block({front - .30f, y - .14f, .70f * car.bonnet},
               {front - .19f, y + .14f, .84f * car.bonnet}, Material::kMetal);
    body.block({-front + .10f, y - .08f, .66f * car.shoulder},
               {-front + .22f, y + .08f, .90f * car.shoulder}, Material::kRetroreflector);
    body.block({-front + .095f, y - .05f, .48f * car.shoulder},
               {-front + .17f, y + .05f, .53f * car.shoulder}, Material::kRetroreflector);
  }
  body.block({front - .15f, -.26f, .42f * car.bonnet},
             {front - .085f, .26f, .42f * car.bonnet + .11f}, Material::kRetroreflector);
  body.block({-front + .03f, -.26f, .56f * car.shoulder},
             {-front + .09f, .26f, .56f * car.shoulder + .11f}, Material::kRetroreflector);
}

void add_mirrors(MeshBuilder& overhang, const CarShape& car) {
  const float x = car.length * (0.5f - car.cowl) - .28f, half = 0.5f * car.width;
  for (const float sign : {-1.0f, 1.0f}) {
    const float inner = sign * .90f * half,
                outer = sign * (half + static_cast<float>(kMirrorOverhang) - .005f);
    overhang.block({x - .05f, std::min(inner, outer), car.shoulder - .02f},
                   {x + .06f, std::max(inner, outer), car.shoulder + .12f}, Material::kPaintLight);
  }
}

}  // namespace

void build_vehicle(ModelKind kind, Dice& dice, MeshBuilder& body, MeshBuilder& overhang) {
  const CarShape car = shape_of(kind, dice);
  const bool van = kind == ModelKind::kPanelVan;
  const bool side_windows = !van;
  loft(body, stations_of(car, side_windows, !van || dice.chance(0.5)));
  const float half = 0.5f * car.width;
  const float front_axle = car.length * dice.uniform(.30, .325),
              rear_axle = -car.length * dice.uniform(.275, .30);
  for (const float sign : {-1.0f, 1.0f}) {
    for (const float x : {front_axle, rear_axle}) {
      add_wheel(body, x, sign * half, sign * (half - .22f), car.wheel);
    }
  }
  const float cushion = car.bottom + .30f, back = car.shoulder + .06f;
  const float cabin_front = car.length * (.5f - car.cowl), dashboard = cabin_front - .30f;
  body.block({dashboard - .25f, -.82f * half, car.bottom + .25f},
             {dashboard + .10f, .82f * half, car.shoulder - .04f}, Material::kPlastic);
  const float seat_y = .44f * half;
  add_seat(body, dashboard - 1.05f, seat_y, .5f, cushion, back);
  add_seat(body, dashboard - 1.05f, -seat_y, .5f, cushion, back);
  if (van) {
    const float wall = dashboard - 1.30f;
    body.block({wall - .04f, -.93f * half, car.bottom + .1f}, {wall, .93f * half, car.height - .2f},
               Material::kMetal);
  } else {
    add_seat(body, dashboard - 1.95f, 0.0f, 1.5f * half, cushion + .02f, back);
    if (kind == ModelKind::kMinibus) {
      add_seat(body, dashboard - 2.8f, 0.0f, 1.5f * half, cushion + .02f, back);
    }
  }
  if (dice.chance(0.25)) {
    body.ellipsoid({dashboard - .88f, seat_y, car.shoulder + .22f}, {.11f, .09f, .13f},
                   Material::kSkin, 4, 7);
    body.ellipsoid({dashboard - .90f, seat_y, car.shoulder - .08f}, {.14f, .23f, .24f},
                   Material::kCloth, 4, 7);
  }
  add_lamps_and_plates(body, car);
  if (!van && dice.chance(0.8)) {
    const float x = car.length * (.5f - car.roof_rear + .05f), top = car.height - .01f;
    body.cylinder({x, 0, top - .02f}, {x - .04f, 0, top + dice.uniform(.04, .09)}, .02f, .008f, 5,
                  Material::kPlastic);
  }
  add_mirrors(overhang, car);
}

}  // namespace arbox::simulation
