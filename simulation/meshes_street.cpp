#include <algorithm>
#include <cmath>
#include <vector>

#include "arbox/simulation/internal/model_builders.h"

namespace arbox::simulation {
namespace {

constexpr Material kMetal = Material::kMetal;

void add_pole(MeshBuilder& body, float height, float radius) {
  body.cylinder({0, 0, 0}, {0, 0, height}, radius, .8f * radius, 8, kMetal);
}

void add_lamp(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(4, 8), reach = dice.uniform(.2, 1.4);
  add_pole(body, height, dice.uniform(.06, .09));
  body.cylinder({0, 0, .9f * height}, {0, reach, height}, .04f, .03f, 6, kMetal);
  body.block({-.12f, reach, height - .08f}, {.12f, reach + .5f, height + .06f}, Material::kPlastic);
}

void add_sign(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(2.1, 2.8);
  add_pole(body, height, .03f);
  const int shape = dice.below(3);
  std::vector<Point> front;
  const int corners = shape == 0 ? 12 : shape == 1 ? 3 : 4;
  const float radius = shape == 2 ? .38f : .33f;
  for (int i = 0; i < corners; ++i) {
    const float angle = 1.5707963f + (shape == 2 ? .7853982f : 0.0f) +
                        6.2831853f * static_cast<float>(i) / static_cast<float>(corners);
    front.push_back({.04f, radius * std::cos(angle), height - .3f + radius * std::sin(angle)});
  }
  body.fan(front, Material::kRetroreflector);
  for (Point& point : front) point.x() = .035f;
  std::reverse(front.begin(), front.end());
  body.fan(front, kMetal);
}

void add_traffic_light(MeshBuilder& body) {
  add_pole(body, 3.2f, .06f);
  body.block({.05f, -.16f, 2.25f}, {.25f, .16f, 3.15f}, Material::kPlastic);
  body.block({-.25f, -.14f, 2.1f}, {-.05f, .14f, 2.7f}, Material::kPlastic);
}

void add_bench(MeshBuilder& body) {
  for (int i = 0; i < 3; ++i) {
    const float y = -.2f + .16f * static_cast<float>(i);
    body.block({-.8f, y, .42f}, {.8f, y + .12f, .46f}, Material::kWood);
  }
  body.block({-.8f, -.27f, .55f}, {.8f, -.23f, .85f}, Material::kWood);
  for (const float x : {-.6f, .6f}) {
    body.block({x - .03f, -.25f, 0}, {x + .03f, .22f, .42f}, kMetal);
    body.block({x - .03f, -.26f, .42f}, {x + .03f, -.22f, .85f}, kMetal);
  }
}

void add_wheeled_bin(MeshBuilder& body, Dice& dice) {
  const float half = dice.uniform(.25, .32), height = dice.uniform(.95, 1.1);
  body.block({-half, -half, .06f}, {half, half, height}, Material::kPlastic);
  body.block({-half - .06f, -half, height}, {half + .03f, half, height + .06f}, Material::kPlastic);
  body.cylinder({-half, -half, .1f}, {-half, half, .1f}, .1f, .1f, 8, Material::kRubber);
}

void add_picket_fence(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(.8, 1.3), gap = dice.uniform(.11, .18);
  const Material material = dice.chance(0.6) ? Material::kWood : kMetal;
  const float half = material == kMetal ? .012f : .04f;
  for (float x = -1; x < 1; x += gap) {
    body.block({x - half, -.012f, .06f}, {x + half, .012f, height}, material);
  }
  for (const float z : {.25f, height - .15f}) {
    body.block({-1, -.03f, z}, {1, -.012f, z + .07f}, material);
  }
  body.block({-1, -.05f, 0}, {-.92f, .05f, height + .05f}, material);
}

void add_mesh_fence(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(1.2, 2.0);
  for (const float x : {-1.0f, .97f}) {
    body.cylinder({x, 0, 0}, {x, 0, height}, .025f, .025f, 6, kMetal);
  }
  for (float z = .1f; z < height; z += .2f) {
    body.block({-1, -.004f, z}, {1, .004f, z + .008f}, kMetal);
  }
  for (float x = -1; x < 1; x += .05f) {
    body.block({x, -.004f, .05f}, {x + .007f, .004f, height}, kMetal);
  }
}

}  // namespace

void build_furniture(ModelKind kind, Dice& dice, MeshBuilder& body) {
  switch (kind) {
    case ModelKind::kPole:
      return add_pole(body, dice.uniform(2.5, 6), dice.uniform(.04, .12));
    case ModelKind::kStreetLamp:
      return add_lamp(body, dice);
    case ModelKind::kTrafficSign:
      return add_sign(body, dice);
    case ModelKind::kTrafficLight:
      return add_traffic_light(body);
    case ModelKind::kBollard:
      return add_pole(body, dice.uniform(.7, 1.1), dice.uniform(.04, .10));
    case ModelKind::kLitterBin:
      body.cylinder({0, 0, .25f}, {0, 0, .85f}, .2f, .22f, 10, Material::kPlastic);
      return body.cylinder({0, -.24f, 0}, {0, -.24f, 1.1f}, .03f, .03f, 6, kMetal);
    case ModelKind::kWheeledBin:
      return add_wheeled_bin(body, dice);
    case ModelKind::kSwitchCabinet:
      return body.block({-dice.uniform(.3, .7), -.17f, 0},
                        {dice.uniform(.3, .7), .17f, dice.uniform(.9, 1.5)}, Material::kPlastic);
    case ModelKind::kCrate:
      return body.block({-dice.uniform(.2, .6), -.35f, 0},
                        {dice.uniform(.2, .6), .35f, dice.uniform(.3, 1.0)}, Material::kWood);
    case ModelKind::kBench:
      return add_bench(body);
    case ModelKind::kWall: {
      const float height = dice.uniform(.5, 2.0);
      body.block({-1, -.12f, 0}, {1, .12f, height}, Material::kBrick);
      return body.block({-1, -.16f, height}, {1, .16f, height + .06f}, Material::kConcrete);
    }
    case ModelKind::kPicketFence:
      return add_picket_fence(body, dice);
    case ModelKind::kMeshFence:
      return add_mesh_fence(body, dice);
    default:  // guard rail
      body.block({-2, -.04f, .45f}, {2, .04f, .75f}, kMetal);
      return body.block({-.06f, .04f, 0}, {.06f, .14f, .72f}, kMetal);
  }
}

namespace {

/// The front at y = 0, towards +y, with recessed windows in a grid.
void add_front(MeshBuilder& body, float half, float from, float to, int columns, Dice& dice,
               Material wall) {
  const float recess = dice.uniform(.06, .22), pitch = 2 * half / static_cast<float>(columns);
  const float window = pitch * dice.uniform(.35, .6), sill = from + dice.uniform(.7, 1.1),
              lintel = std::min(sill + dice.uniform(1.1, 1.5), to - .25f);
  const int door = dice.below(columns);
  const bool curtains = dice.chance(0.7);
  for (int i = 0; i < columns; ++i) {
    const float left = -half + pitch * static_cast<float>(i), right = left + pitch;
    const bool is_door = i == door && from < 1.0f;
    const float a = .5f * (left + right - window), b = .5f * (left + right + window);
    const float bottom = is_door ? from + .02f : sill;
    const auto panel = [&](float x0, float z0, float x1, float z1) {
      body.quad({x0, 0, z0}, {x1, 0, z0}, {x1, 0, z1}, {x0, 0, z1}, wall);
    };
    panel(left, from, a, to);
    panel(b, from, right, to);
    panel(a, from, b, bottom);
    panel(a, lintel, b, to);
    const float y = -recess;
    body.quad({a, 0, bottom}, {b, 0, bottom}, {b, y, bottom}, {a, y, bottom}, Material::kConcrete);
    body.quad({a, 0, lintel}, {b, 0, lintel}, {b, y, lintel}, {a, y, lintel}, Material::kConcrete);
    body.quad({a, 0, bottom}, {a, 0, lintel}, {a, y, lintel}, {a, y, bottom}, Material::kConcrete);
    body.quad({b, 0, bottom}, {b, 0, lintel}, {b, y, lintel}, {b, y, bottom}, Material::kConcrete);
    body.quad({a, y, bottom}, {b, y, bottom}, {b, y, lintel}, {a, y, lintel},
              is_door ? Material::kWood : Material::kGlass);
    if (!is_door) {
      const float behind = y - (curtains ? .15f : 1.8f);
      body.quad({a - .5f, behind, bottom - .3f}, {b + .5f, behind, bottom - .3f},
                {b + .5f, behind, lintel}, {a - .5f, behind, lintel}, Material::kCloth);
    }
  }
}

}  // namespace

void build_building(ModelKind kind, Dice& dice, MeshBuilder& body) {
  const bool hall = kind == ModelKind::kHall, town = kind == ModelKind::kTownHouse;
  const float half = .5f * (hall ? dice.uniform(18, 30) : dice.uniform(8, 13));
  const float depth = hall ? 15.0f : 10.0f, storey = hall ? 4.5f : 2.9f;
  const int storeys = hall ? 1 : town ? 3 + dice.below(2) : 1 + dice.below(2);
  const Material wall = hall ? kMetal : dice.chance(.7) ? Material::kPlaster : Material::kBrick;
  const float base = .3f, top = base + storey * static_cast<float>(storeys);
  const int columns = std::max(2, static_cast<int>(2 * half / (hall ? 6.0f : 2.8f)));
  for (int i = 0; i < storeys; ++i) {
    const float from = base + storey * static_cast<float>(i);
    add_front(body, half, from, from + storey, columns, dice, wall);
  }
  body.block({-half, -.3f, -.6f}, {half, .05f, base}, Material::kConcrete);
  for (const float x : {-half, half}) {
    body.quad({x, 0, -.6f}, {x, -depth, -.6f}, {x, -depth, top}, {x, 0, top}, wall);
  }
  body.quad({-half, -depth, -.6f}, {half, -depth, -.6f}, {half, -depth, top}, {-half, -depth, top},
            wall);
  const float ridge = top + (hall ? .5f : dice.uniform(2, 4));
  for (const float y : {0.0f, -depth}) {
    const float eave = y == 0.0f ? .5f : -depth - .5f;
    body.quad({-half, eave, top - .2f}, {half, eave, top - .2f}, {half, -.5f * depth, ridge},
              {-half, -.5f * depth, ridge}, Material::kBrick);
  }
  for (const float x : {-half, half}) {
    body.triangle({x, 0, top}, {x, -depth, top}, {x, -.5f * depth, ridge}, wall);
  }
  if (!hall && dice.chance(.4)) {
    const float x = dice.uniform(-.6, .6) * half, w = dice.uniform(.7, 1.4);
    body.block({x - w, 0, base + storey}, {x + w, dice.uniform(.7, 1.3), base + storey + 1.0f},
               wall);
  }
  if (!hall && dice.chance(.5)) {
    const float x = dice.uniform(-.7, .7) * half;
    body.block({x - .9f, 0, -.2f}, {x + .9f, dice.uniform(.4, 1.2), .25f}, Material::kConcrete);
  }
}

}  // namespace arbox::simulation
