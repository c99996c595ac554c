#include <algorithm>
#include <cmath>

#include "arbox/simulation/internal/road.h"

namespace arbox::simulation {
namespace {

constexpr std::uint32_t kRelief = 7;
/// Streets with narrower lanes have no lines, metres.
constexpr double kNarrowLane = 2.8;

/// Smooth noise of unit spread: random values on a grid, blended.
double noise(std::uint64_t seed, double x, double y, double wavelength, std::uint32_t octave) {
  const double u = x / wavelength, v = y / wavelength;
  const double i = std::floor(u), j = std::floor(v);
  const auto corner = [&](int di, int dj) {
    const auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(i) + di + 100000) << 32 |
                     static_cast<std::uint64_t>(static_cast<std::int64_t>(j) + dj + 100000);
    return RandomStream(seed, key, kRelief).uniform(octave, -1.7, 1.7);
  };
  const auto ease = [](double a) { return a * a * (3 - 2 * a); };
  const double a = ease(u - i), b = ease(v - j);
  return (corner(0, 0) * (1 - a) + corner(1, 0) * a) * (1 - b) +
         (corner(0, 1) * (1 - a) + corner(1, 1) * a) * b;
}

double ramp(double value, double from, double to) {
  return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

Material surface(const Road& road, double s, double t) {
  const RoadSide& side = road.side(t);
  const double distance = std::abs(t);
  if (road.crossing(s, t > 0) || distance < side.curb_line()) return Material::kAsphalt;
  if (distance < side.curb_line() + side.pavement) return Material::kConcrete;
  const bool paved = road.district == District::kInnerCity || road.district == District::kCampus;
  return paved && distance < side.facade_line() ? Material::kConcrete : Material::kGrass;
}

std::vector<double> lines_along(const Road& road, double reach) {
  std::vector<double> lines;
  for (double s = -reach; s <= reach; s += std::abs(s) < 25 ? 0.8 : 1.6) lines.push_back(s);
  for (const Crossing& crossing : road.crossings) {
    for (const double edge : {-crossing.half_width, crossing.half_width}) {
      lines.push_back(crossing.s + edge - 0.01);
      lines.push_back(crossing.s + edge + 0.01);
    }
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

std::vector<double> lines_across(const Road& road, double reach) {
  std::vector<double> lines = {0.0};
  for (const RoadSide* side : {&road.left, &road.right}) {
    for (double t = 0.6; t < reach; t += t < 15 ? 0.6 : 1.8) lines.push_back(side->sign * t);
    for (const double edge : {side->curb_line(), side->curb_line() + side->pavement,
                              side->property_line(), side->facade_line()}) {
      lines.push_back(side->sign * (edge - 0.015));
      lines.push_back(side->sign * (edge + 0.015));
    }
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

}  // namespace

Eigen::Vector2d Road::position(double s, double t) const {
  if (std::abs(curvature) < 1e-7) return {s, t};
  const double angle = curvature * s;
  return {std::sin(angle) / curvature - t * std::sin(angle),
          (1 - std::cos(angle)) / curvature + t * std::cos(angle)};
}

const Crossing* Road::crossing(double s, bool to_left, double margin) const {
  for (const Crossing& one : crossings) {
    if ((to_left ? one.left : one.right) && std::abs(s - one.s) < one.half_width + margin) {
      return &one;
    }
  }
  return nullptr;
}

double Road::height(double s, double t) const {
  const Eigen::Vector2d place = position(s, t);
  const RoadSide& here = side(t);
  const double distance = std::abs(t);
  double z = -sensor_height + slope_x * s + slope_y * t + 0.5 * vertical_curvature * s * s;
  const bool crosses = crossing(s, t > 0) != nullptr;
  const double rise = crosses ? 0.15 : 1.0;
  z += rise * here.curb * ramp(distance, here.curb_line() - 0.015, here.curb_line() + 0.015);
  const double off = std::max(0.0, distance - here.property_line());
  z += (crosses ? 0.3 : 1.0) * here.bank * std::min(off, 25.0);
  const double wild = 0.25 + 0.75 * ramp(off, 0.0, 3.0);
  z += roughness * (0.030 * noise(seed, place.x(), place.y(), 2.3, 0) * wild * wild +
                    0.045 * noise(seed, place.x(), place.y(), 11.0, 1) * wild +
                    0.08 * noise(seed, place.x(), place.y(), 43.0, 2) *
                        std::min(1.0, place.squaredNorm() / 900.0));
  return z;
}

std::shared_ptr<const TriangleMesh> ground_mesh(const Road& road, double reach) {
  const std::vector<double> along = lines_along(road, reach), across = lines_across(road, reach);
  const auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices.reserve(along.size() * across.size());
  for (const double s : along) {
    for (const double t : across) {
      const Eigen::Vector2d place = road.position(s, t);
      mesh->vertices.emplace_back(place.x(), place.y(), road.height(s, t));
    }
  }
  const auto columns = static_cast<std::uint32_t>(across.size());
  for (std::uint32_t i = 0; i + 1 < along.size(); ++i) {
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const std::uint32_t a = i * columns + j, b = a + columns;
      mesh->triangles.push_back({a, b, b + 1});
      mesh->triangles.push_back({a, b + 1, a + 1});
      const Material material =
          surface(road, 0.5 * (along[i] + along[i + 1]), 0.5 * (across[j] + across[j + 1]));
      mesh->materials.insert(mesh->materials.end(), 2, material);
    }
  }
  return mesh;
}

RoadMarkings markings_of(const Road& road) {
  RoadMarkings markings{.curvature = road.curvature, .lines = {}, .gaps = {}};
  const bool large = road.district == District::kRoad || road.district == District::kHighway;
  if (!large && road.lane_width < kNarrowLane) return markings;
  for (int lane = 0; lane < road.lanes_opposite; ++lane) {
    markings.lines.push_back({(lane + 0.5) * road.lane_width, lane > 0 || !large});
  }
  for (int lane = 0; lane + 1 < road.lanes_same; ++lane) {
    markings.lines.push_back({-(lane + 0.5) * road.lane_width, true});
  }
  if (large) {
    markings.lines.push_back({road.left.edge - 0.2, false});
    markings.lines.push_back({-road.right.edge + 0.2, false});
  }
  for (const Crossing& crossing : road.crossings) {
    const double from = crossing.s - crossing.half_width - 0.5, to = 2 * crossing.s - from;
    if (crossing.left) markings.gaps.push_back({from, to, true});
    if (crossing.right) markings.gaps.push_back({from, to, false});
  }
  return markings;
}

}  // namespace arbox::simulation
