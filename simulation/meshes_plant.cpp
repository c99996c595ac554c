#include <cmath>
#include <numbers>

#include "arbox/simulation/internal/model_builders.h"

namespace arbox::simulation {
namespace {

Point direction(Dice& dice) {
  const float z = dice.uniform(-1, 1), angle = dice.uniform(0, 2 * std::numbers::pi);
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

void add_leaf(MeshBuilder& body, const Point& center, float size, Dice& dice) {
  const Point normal = direction(dice);
  const Point other = std::abs(normal.z()) < 0.9f ? Point::UnitZ() : Point::UnitX();
  const Point u = size * normal.cross(other).normalized(), v = normal.cross(u);
  body.triangle(center - u - v, center + u - .6f * v, center + .2f * u + v, Material::kFoliage);
}

/// Leaves in a shell: most near the surface of the ellipsoid.
void add_crown(MeshBuilder& body, const Point& center, const Point& radii, int leaves, float size,
               Dice& dice) {
  for (int i = 0; i < leaves; ++i) {
    const float depth = std::pow(dice.uniform(0, 1), 0.4f);
    const Point place = center + depth * radii.cwiseProduct(direction(dice));
    add_leaf(body, place, size * dice.uniform(.6, 1.4), dice);
  }
}

void add_broad_tree(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(5, 11), trunk = dice.uniform(1.9, 3.0);
  const float radius = dice.uniform(.09, .24);
  body.cylinder({0, 0, 0}, {dice.uniform(-.1, .1), dice.uniform(-.1, .1), .6f * height}, radius,
                .5f * radius, 9, Material::kBark);
  const float spread = dice.uniform(1.6, 3.4);
  for (int i = 0; i < 5; ++i) {
    const Point tip{dice.uniform(-.7, .7) * spread, dice.uniform(-.7, .7) * spread,
                    dice.uniform(trunk + .6, .8 * height)};
    body.cylinder({0, 0, dice.uniform(trunk, trunk + .8)}, tip, .35f * radius, .02f, 5,
                  Material::kBark);
    add_crown(body, tip, {.5f * spread, .5f * spread, .3f * spread}, 420, .11f, dice);
  }
  const float middle = .5f * (trunk + height);
  add_crown(body, {0, 0, middle + .3f}, {spread, spread, .5f * (height - trunk)}, 1500, .13f, dice);
}

void add_conifer(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(3, 9), spread = dice.uniform(.7, 1.8);
  body.cylinder({0, 0, 0}, {0, 0, height}, .12f, .02f, 7, Material::kBark);
  for (int i = 0; i < 1800; ++i) {
    const float up = std::pow(dice.uniform(0, 1), 1.5f);
    const float r = spread * (1 - up) * std::sqrt(dice.uniform(.2, 1));
    const float angle = dice.uniform(0, 2 * std::numbers::pi);
    add_leaf(body, {r * std::cos(angle), r * std::sin(angle), .3f + up * (height - .4f)},
             .09f * dice.uniform(.6, 1.4), dice);
  }
}

void add_bush(MeshBuilder& body, Dice& dice) {
  const int lumps = 3 + dice.below(4);
  for (int i = 0; i < lumps; ++i) {
    const float r = dice.uniform(.25, .7), h = dice.uniform(.3, .9);
    const Point center{dice.uniform(-.9, .9), dice.uniform(-.7, .7), dice.uniform(.6, 1.1) * h};
    add_crown(body, center, {1.25f * r, 1.25f * r, 1.15f * h}, 300, .05f, dice);
    body.ellipsoid(center - Point(0, 0, .1f), {.5f * r, .5f * r, .55f * h}, Material::kFoliage, 4,
                   7);
  }
  for (int i = 0; i < 4; ++i) {
    body.cylinder({0, 0, 0}, {dice.uniform(-.4, .4), dice.uniform(-.4, .4), .7f}, .02f, .01f, 4,
                  Material::kBark);
  }
}

/// A clipped hedge: a solid heart, twigs in front of it.
void add_hedge(MeshBuilder& body, Dice& dice) {
  const float height = dice.uniform(1.1, 1.9), half = dice.uniform(.3, .5);
  body.block({-1, -half + .16f, 0}, {1, half - .16f, height - .14f}, Material::kFoliage);
  for (int i = 0; i < 1100; ++i) {
    const float face = dice.uniform(0, 2 * height + 2 * half);
    const float depth = .20f * dice.uniform(0, 1) * dice.uniform(.2, 1);
    Point place{dice.uniform(-1, 1), 0, 0};
    if (face < 2 * height) {
      const float sign = face < height ? -1.0f : 1.0f;
      place.y() = sign * (half - depth);
      place.z() = face < height ? face : face - height;
    } else {
      place.y() = face - 2 * height - half;
      place.z() = height - depth;
    }
    add_leaf(body, place, .045f * dice.uniform(.6, 1.4), dice);
  }
}

}  // namespace

void build_plant(ModelKind kind, Dice& dice, MeshBuilder& body) {
  switch (kind) {
    case ModelKind::kBroadTree:
      return add_broad_tree(body, dice);
    case ModelKind::kConifer:
      return add_conifer(body, dice);
    case ModelKind::kTrunk: {
      const float radius = dice.uniform(.08, .2);
      return body.cylinder({0, 0, 0}, {0, 0, dice.uniform(2.5, 5)}, radius, .7f * radius, 9,
                           Material::kBark);
    }
    case ModelKind::kBush:
      return add_bush(body, dice);
    default:
      return add_hedge(body, dice);
  }
}

}  // namespace arbox::simulation
