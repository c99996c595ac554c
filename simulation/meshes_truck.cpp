#include <algorithm>
#include <vector>

#include "arbox/simulation/internal/model_builders.h"
#include "arbox/simulation/internal/vehicle_parts.h"

namespace arbox::simulation {

void build_truck(Dice& dice, bool articulated, MeshBuilder& body, MeshBuilder& overhang) {
  const float length = articulated ? dice.uniform(13.5, 16.5) : dice.uniform(6.2, 10.5);
  const float width = dice.uniform(2.4, 2.6), half = .5f * width;
  const float height = articulated ? dice.uniform(3.6, 4.0) : dice.uniform(2.8, 3.5);
  const float cab = articulated ? 2.2f : dice.uniform(1.7, 2.1);
  const float front = .5f * length, cab_top = std::min(height - .05f, dice.uniform(2.5, 3.2));
  const float cab_back = front - cab;
  constexpr Material kPaint = Material::kPaintLight;
  const std::vector<Station> stations = {
      {front, .50f, 1.25f, 1.30f, .92f * half, .90f * half, kPaint, Material::kGlass},
      {front - .12f, .45f, 1.30f, cab_top - .45f, half, .93f * half, Material::kGlass, kPaint},
      {front - .45f, .45f, 1.35f, cab_top - .05f, half, .93f * half, Material::kGlass, kPaint},
      {front - 1.3f, .45f, 1.35f, cab_top - .045f, half, .93f * half, kPaint, kPaint},
      {cab_back, .50f, 1.35f, cab_top - .045f, half, .93f * half, kPaint, kPaint}};
  loft(body, stations);
  add_seat(body, cab_back + .5f, .45f * half, .55f, 1.1f, 1.75f);
  add_seat(body, cab_back + .5f, -.45f * half, .55f, 1.1f, 1.75f);
  const bool flat = !articulated && dice.chance(0.3);
  const float bed = 1.05f, bed_front = cab_back - (articulated ? .7f : .12f);
  const float wall_top = flat ? bed + .6f : height;
  const Material wall = dice.chance(0.6) ? kPaint : Material::kCloth;
  body.block({-front, -half, bed}, {bed_front, half, wall_top}, wall);
  if (flat) {
    body.block({-.2f * length, -.6f * half, bed}, {.1f * length, .6f * half, height},
               Material::kWood);
  }
  body.block({-front + .1f, -.35f * half, .70f}, {front - .4f, .35f * half, bed}, Material::kMetal);
  body.block({-front, -.9f * half, .45f}, {-front + .08f, .9f * half, .60f}, Material::kMetal);
  body.block({-front + 3.2f, -half, .5f}, {bed_front - 1.4f, -half + .05f, .95f}, kPaint);
  body.block({-front + 3.2f, half - .05f, .5f}, {bed_front - 1.4f, half, .95f}, kPaint);
  std::vector<float> axles = {front - 1.1f, -front + 1.5f};
  if (length > 8.5f) axles.push_back(-front + 2.7f);
  if (articulated) {
    axles.push_back(-front + 3.9f);
    axles.push_back(front - 4.6f);
  }
  for (const float sign : {-1.0f, 1.0f}) {
    for (const float x : axles) add_wheel(body, x, sign * half, sign * (half - .45f), .48f);
    const float inner = sign * .94f * half, outer = sign * (half + .085f);
    overhang.block({front - .35f, std::min(inner, outer), 1.75f},
                   {front - .25f, std::max(inner, outer), 2.35f}, Material::kPlastic);
    body.block({-front, sign * .8f * half - .1f, .7f},
               {-front + .05f, sign * .8f * half + .1f, .8f}, Material::kRetroreflector);
  }
}

void build_tram(Dice& dice, MeshBuilder& body) {
  const float length = dice.chance(0.7) ? dice.uniform(13.0, 18.0) : dice.uniform(26.0, 33.0);
  const float half = .5f * dice.uniform(2.3, 2.65), height = dice.uniform(3.3, 3.7);
  const float front = .5f * length, shoulder = 1.6f, roof = height - .30f;
  constexpr Material kPaint = Material::kPaintLight, kGlass = Material::kGlass;
  std::vector<Station> list = {
      {front, .45f, 1.3f, 1.35f, .70f * half, .68f * half, kPaint, kGlass},
      {front - .35f, .38f, shoulder, roof - .5f, .90f * half, .80f * half, kGlass, kPaint},
      {front - .9f, .35f, shoulder, roof, half, .92f * half, kGlass, kPaint}};
  for (float x = front - 2.2f; x > -front + 1.6f; x -= 1.7f) {
    list.push_back({x, .35f, shoulder, roof, half, .92f * half, kPaint, kPaint});
    list.push_back({x - .22f, .35f, shoulder, roof, half, .92f * half, kGlass, kPaint});
  }
  list.push_back({-front + .9f, .35f, shoulder, roof, half, .92f * half, kGlass, kPaint});
  list.push_back(
      {-front + .35f, .38f, shoulder, roof - .5f, .90f * half, .80f * half, kPaint, kGlass});
  list.push_back({-front, .45f, 1.3f, 1.35f, .70f * half, .68f * half, kPaint, kPaint});
  loft(body, list);
  for (float x = front - 2.8f; x > -front + 2.0f; x -= .9f) {
    add_seat(body, x, .55f * half, .85f, 1.15f, 1.75f);
    add_seat(body, x, -.55f * half, .85f, 1.15f, 1.75f);
  }
  for (const float x : {.62f * front, -.62f * front}) {
    for (const float axle : {x - .9f, x + .9f}) {
      body.cylinder({axle, -.6f, .33f}, {axle, .6f, .33f}, .33f, .33f, 12, Material::kMetal);
    }
    body.block({x - 1.3f, -.8f, .12f}, {x + 1.3f, .8f, .4f}, Material::kMetal);
  }
  body.block({-.6f, -.6f, roof}, {1.2f, .6f, height}, Material::kMetal);
}

void build_trailer(Dice& dice, MeshBuilder& body) {
  const float length = dice.uniform(2.2, 4.5), half = .5f * dice.uniform(1.4, 2.2);
  const float height = dice.uniform(1.2, 2.6), front = .5f * length;
  const float box_front = front - .9f;
  body.block({-front, -half, .5f}, {box_front, half, height},
             dice.chance(0.5) ? Material::kCloth : Material::kPaintLight);
  body.cylinder({box_front, 0, .52f}, {front, 0, .52f}, .04f, .04f, 6, Material::kMetal);
  body.cylinder({front - .25f, 0, 0}, {front - .25f, 0, .5f}, .06f, .03f, 6, Material::kMetal);
  for (const float sign : {-1.0f, 1.0f}) {
    add_wheel(body, -.15f * length, sign * half, sign * (half - .18f), .30f);
    body.block({-front, sign * .75f * half - .06f, .55f},
               {-front + .02f, sign * .75f * half + .06f, .67f}, Material::kRetroreflector);
  }
}

}  // namespace arbox::simulation
