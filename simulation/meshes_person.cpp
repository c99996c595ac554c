#include <cmath>

#include "arbox/simulation/internal/model_builders.h"

namespace arbox::simulation {
namespace {

constexpr Material kClothes = Material::kCloth;

Point swing(float length, float angle) {
  return {length * std::sin(angle), 0.0f, -length * std::cos(angle)};
}

void add_leg(MeshBuilder& body, const Point& hip, float thigh_angle, float shin_angle) {
  const Point knee = hip + swing(.43f, thigh_angle);
  const Point ankle = knee + swing(.40f, shin_angle);
  body.limb(hip, knee, .098f, .070f, kClothes);
  body.limb(knee, ankle, .070f, .052f, kClothes);
  body.ellipsoid(ankle + Point(.07f, 0, -.04f), {.13f, .045f, .045f}, Material::kRubber, 4, 7);
}

void add_arm(MeshBuilder& body, const Point& shoulder, float upper_angle, float lower_angle,
             float outward) {
  Point elbow = shoulder + swing(.30f, upper_angle);
  elbow.y() += outward;
  const Point hand = elbow + swing(.27f, lower_angle);
  body.limb(shoulder, elbow, .062f, .052f, kClothes);
  body.limb(elbow, hand, .042f, .034f, kClothes);
  body.ellipsoid(hand + swing(.07f, lower_angle), {.04f, .03f, .07f}, Material::kSkin, 4, 6);
}

void add_head(MeshBuilder& body, const Point& neck, Dice& dice) {
  body.limb(neck, neck + Point(.01f, 0, .10f), .055f, .055f, Material::kSkin);
  body.ellipsoid(neck + Point(.02f, 0, .20f), {.10f, .078f, .125f}, Material::kSkin, 6, 9);
  if (dice.chance(0.7)) {
    body.ellipsoid(neck + Point(-.005f, 0, .235f), {.105f, .088f, .10f}, kClothes, 5, 8);
  }
}

void add_bag(MeshBuilder& body, Dice& dice, float shoulder_height) {
  const float draw = dice.uniform(0, 1);
  if (draw < 0.25f) {
    body.ellipsoid({-.22f, 0, shoulder_height - .25f}, {.12f, .16f, .24f}, kClothes);
  } else if (draw < 0.45f) {
    const float y = dice.chance(0.5) ? .30f : -.30f;
    body.block({-.18f, y - .06f, .42f}, {.18f, y + .06f, .74f}, kClothes);
    body.cylinder({0, y, .74f}, {0, .6f * y, shoulder_height}, .012f, .012f, 4, kClothes);
  } else if (draw < 0.52f) {
    body.block({-.62f, -.28f, .12f}, {-.38f, .02f, .62f}, Material::kPlastic);
    body.cylinder({-.48f, -.13f, .62f}, {-.22f, -.22f, .80f}, .015f, .015f, 4, Material::kMetal);
    body.cylinder({-.56f, -.26f, .05f}, {-.56f, 0, .05f}, .05f, .05f, 6, Material::kRubber);
  }
}

void add_torso(MeshBuilder& body, const Point& hip, const Point& chest, float girth) {
  body.limb(hip, chest, .14f * girth, .145f * girth, kClothes);
  body.ellipsoid(hip + Point(0, 0, .02f), {.13f * girth, .175f * girth, .15f}, kClothes, 5, 9);
  body.ellipsoid(chest, {.13f * girth, .205f * girth, .19f}, kClothes, 6, 10);
}

}  // namespace

void build_pedestrian(Dice& dice, MeshBuilder& body) {
  const bool walks = dice.chance(0.78);
  const float stride = walks ? dice.uniform(.18, .48) : dice.uniform(0, .06);
  const float girth = dice.uniform(1.0, 1.4);
  const float hip_height = .92f - .30f * stride * stride;
  const float lean = walks ? dice.uniform(.0, .08) : 0.0f;
  const Point hip(0, 0, hip_height), chest(lean, 0, hip_height + .42f);
  const float bend = walks ? dice.uniform(.05, .35) : 0.0f;
  add_leg(body, hip + Point(0, .095f, 0), stride, stride - .3f * bend);
  add_leg(body, hip + Point(0, -.095f, 0), -stride, -stride - bend);
  add_torso(body, hip, chest, girth);
  const float reach = walks ? dice.uniform(.2, .6) : dice.uniform(0, .2);
  const float bent = dice.uniform(.1, .5);
  const bool carries = dice.chance(0.2), phone = dice.chance(0.15);
  const Point shoulder(lean, 0, hip_height + .56f);
  const float side = .205f * girth;
  add_arm(body, shoulder + Point(0, side, 0), carries ? .3f : -reach, carries ? 1.5f : bent - reach,
          dice.uniform(.02, .10));
  add_arm(body, shoulder + Point(0, -side, 0), phone ? .4f : reach, phone ? 2.1f : reach + bent,
          -dice.uniform(.02, .10));
  if (carries) body.block({.25f, -.2f, 1.0f}, {.5f, .2f, 1.3f}, Material::kWood);
  add_head(body, shoulder + Point(.01f, 0, .04f), dice);
  add_bag(body, dice, shoulder.z());
  if (!walks && dice.chance(0.3)) body.limb(hip, hip - Point(0, 0, .45f), .2f, .26f, kClothes);
}

void build_person_sitting(Dice& dice, MeshBuilder& body) {
  const Point hip(-.15f, 0, .50f);
  const float lean = dice.uniform(-.12, .1);
  const Point chest = hip + Point(lean, 0, .40f);
  for (const float sign : {-1.0f, 1.0f}) {
    const float spread = dice.uniform(.0, .10);
    add_leg(body, hip + Point(.02f, sign * (.10f + spread), 0), 1.5f, dice.uniform(-.2, .3));
    add_arm(body, chest + Point(0, sign * .21f, .13f), .4f, dice.uniform(.9, 1.7),
            sign * dice.uniform(.02, .08));
  }
  add_torso(body, hip, chest, 1.05f);
  add_head(body, chest + Point(.01f, 0, .18f), dice);
  body.block({-.36f, -.22f, .36f}, {.10f, .22f, .42f}, Material::kWood);
  body.block({-.38f, -.22f, .42f}, {-.33f, .22f, .85f}, Material::kWood);
  for (const float x : {-.34f, .07f}) {
    for (const float y : {-.2f, .2f}) {
      body.cylinder({x, y, 0}, {x, y, .38f}, .02f, .02f, 5, Material::kMetal);
    }
  }
}

namespace {

void add_bicycle_wheel(MeshBuilder& body, float x, float radius) {
  constexpr int kParts = 18;
  const auto at = [&](int i, float r, float y) {
    const float angle = 6.2831853f * static_cast<float>(i) / kParts;
    return Point(x + r * std::cos(angle), y, radius + r * std::sin(angle));
  };
  for (int i = 0; i < kParts; ++i) {
    for (const float y : {-.02f, .02f}) {
      body.quad(at(i, radius - .055f, y), at(i + 1, radius - .055f, y), at(i + 1, radius, 0),
                at(i, radius, 0), Material::kRubber);
    }
    if (i % 2 == 0) {
      body.cylinder(at(i, .02f, 0), at(i, radius - .05f, 0), .004f, .004f, 3, Material::kMetal);
    }
  }
}

/// Gives the place of the saddle and of the grips.
std::pair<Point, Point> add_bicycle(MeshBuilder& body, Dice& dice) {
  const float radius = .34f, base = dice.uniform(1.0, 1.12), front = .5f * base, rear = -front;
  add_bicycle_wheel(body, front, radius);
  add_bicycle_wheel(body, rear, radius);
  const Point crank(-.07f, 0, .28f), saddle(-.24f, 0, .95f), head(front - .22f, 0, .88f);
  const Point grips = head + Point(dice.uniform(-.10, .05), 0, dice.uniform(.08, .2));
  const auto tube = [&](const Point& a, const Point& b, float radius_of_tube) {
    body.cylinder(a, b, radius_of_tube, radius_of_tube, 6, Material::kPaintLight);
  };
  tube(crank, saddle, .018f);
  tube(crank, head - Point(0, 0, .12f), .02f);
  tube(saddle - Point(-.05f, 0, .15f), head, .018f);
  tube(crank, {rear, 0, radius}, .012f);
  tube(saddle - Point(-.04f, 0, .14f), {rear, 0, radius}, .012f);
  tube({front, 0, radius}, grips, .02f);
  tube(grips + Point(0, -.29f, 0), grips + Point(0, .29f, 0), .016f);
  body.ellipsoid(saddle + Point(-.02f, 0, .02f), {.13f, .08f, .04f}, Material::kRubber, 4, 8);
  body.block({rear - .02f, -.03f, .70f}, {rear + .02f, .03f, .76f}, Material::kRetroreflector);
  if (dice.chance(0.4)) {
    body.block({rear - .18f, -.07f, .70f}, {rear + .2f, .07f, .73f}, Material::kMetal);
  }
  return {saddle, grips};
}

}  // namespace

void build_bicycle(Dice& dice, MeshBuilder& body) { add_bicycle(body, dice); }

void build_cyclist(Dice& dice, MeshBuilder& body) {
  const auto [saddle, grips] = add_bicycle(body, dice);
  const Point hip = saddle + Point(.02f, 0, .10f);
  const float lean = dice.uniform(.12, .34);
  const Point chest = hip + Point(lean, 0, .40f - .25f * lean);
  const float phase = dice.uniform(-1, 1);
  for (const float sign : {-1.0f, 1.0f}) {
    const float lift = sign * phase;
    const float thigh = .95f + .35f * lift;
    add_leg(body, hip + Point(0, sign * .10f, 0), thigh, -.15f + .35f * lift);
    const Point shoulder = chest + Point(.03f, sign * .20f, .12f);
    const Point hand = grips + Point(0, sign * .27f, .03f);
    const Point elbow = .5f * (shoulder + hand) + Point(-.06f, sign * .05f, -.05f);
    body.limb(shoulder, elbow, .052f, .042f, kClothes);
    body.limb(elbow, hand, .042f, .034f, kClothes);
  }
  add_torso(body, hip, chest, dice.uniform(1.2, 1.5));
  add_head(body, chest + Point(.06f, 0, .17f), dice);
  if (dice.chance(0.35)) {
    body.ellipsoid(chest + Point(-.19f, 0, -.02f), {.10f, .15f, .20f}, kClothes);
  }
}

}  // namespace arbox::simulation
