#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "arbox/base/parallel.h"
#include "arbox/base/random.h"
#include "support/street_scene.h"

namespace arbox::testing {
namespace {

constexpr double kRange = 80.0;
constexpr int kBeams = 64;
// One 64-beam scanner: two blocks of evenly spread beams, noise and drop-outs as measured on KITTI.
double elevation(int beam) {
  const double degrees = beam < 32 ? 1.94 - beam * 0.3435 : -9.03 - (beam - 32) * 0.5152;
  return degrees * std::numbers::pi / 180.0;
}

std::optional<double> meet_ground(const GroundHeight& ground, const Eigen::Vector3d& direction,
                                  double limit) {
  constexpr double kStep = 0.5;
  const auto above = [&](double t) {
    return t * direction.z() - ground(t * direction.x(), t * direction.y());
  };
  for (double far = kStep; far < limit + kStep; far += kStep) {
    if (above(far) > 0.0) continue;
    double near = far - kStep, end = far;
    for (int halving = 0; halving < 14; ++halving) {
      const double middle = 0.5 * (near + end);
      (above(middle) > 0.0 ? near : end) = middle;
    }
    return end;
  }
  return {};
}

/// Rays that meet an object: at all, and before anything else.
struct RayCount {
  int meeting = 0, first = 0;
};

struct Return {
  Eigen::Vector3d point;
  double intensity;
  int owner;
};

}  // namespace

StreetScene scan(const std::vector<OwnedConvex>& solids, std::vector<geometry::Detection> truth,
                 const GroundHeight& ground, const StreetOptions& options) {
  const int steps = static_cast<int>(2.0 * options.half_view / options.azimuth_step);
  std::vector<std::vector<Return>> beams(kBeams);
  std::vector<std::vector<RayCount>> rays(kBeams, std::vector<RayCount>(truth.size()));
  parallel_for(kBeams, 1, 0, [&](std::int64_t begin, std::int64_t) {
    const int beam = static_cast<int>(begin);
    const RandomStream draw(options.seed, static_cast<std::uint64_t>(beam), 1);
    const double bias = options.noise * 0.02 * draw.normal(0);
    for (int step = 0; step < steps; ++step) {
      const auto first = static_cast<std::uint32_t>(8 * (step + 1));
      const double azimuth =
          (-options.half_view + (step + 0.5) * options.azimuth_step) * std::numbers::pi / 180.0;
      const double v = elevation(beam);
      const Eigen::Vector3d direction(std::cos(v) * std::cos(azimuth),
                                      std::cos(v) * std::sin(azimuth), std::sin(v));
      double distance = kRange, intensity = 0.0, lost = 0.0, cosine = 1.0;
      int owner = -1;
      bool hit_anything = false;
      int last_met = -1;
      for (std::size_t i = 0; i < solids.size(); ++i) {
        const auto hit = enter(solids[i].solid, direction);
        if (!hit) continue;
        // The solids of an object stand together.
        if (solids[i].owner >= 0 && std::exchange(last_met, solids[i].owner) != solids[i].owner) {
          ++rays[beam][solids[i].owner].meeting;
        }
        if (hit->distance >= distance) continue;
        const double luck = RandomStream(options.seed, i, 2)
                                .uniform(static_cast<std::uint32_t>(beam * steps + step));
        if (luck < solids[i].solid.passed) continue;
        distance = hit->distance;
        intensity = solids[i].solid.intensity;
        lost = solids[i].solid.lost;
        cosine = std::abs(hit->normal.dot(direction));
        owner = solids[i].owner;
        hit_anything = true;
      }
      if (const auto floor = meet_ground(ground, direction, distance); floor && *floor < distance) {
        distance = *floor;
        intensity = 0.27;
        lost = 0.0;
        cosine = 0.3;
        owner = -1;
        hit_anything = true;
      }
      if (owner >= 0) ++rays[beam][owner].first;
      const double fading = 0.002 + 0.25 * std::pow(distance / 50.0, 3.0) + 0.05 * (1.0 - cosine);
      if (!hit_anything || draw.uniform(first) < lost + options.noise * fading) continue;
      const double noisy =
          std::round((distance + bias + options.noise * 0.012 * draw.normal(first + 1)) * 500) /
          500;
      const double shine = intensity * (0.5 + 0.5 * cosine) + 0.06 * draw.normal(first + 2);
      beams[beam].push_back({noisy * direction, std::clamp(shine, 0.0, 0.99), owner});
    }
  });
  StreetScene scene{.cloud = {.channels = {"intensity"}, .values = {}},
                    .truth = std::move(truth),
                    .returns = {},
                    .visible = {}};
  scene.returns.assign(scene.truth.size(), 0);
  for (std::size_t object = 0; object < scene.truth.size(); ++object) {
    RayCount sum;
    for (const auto& beam : rays) {
      sum.meeting += beam[object].meeting;
      sum.first += beam[object].first;
    }
    scene.visible.push_back(sum.meeting > 0 ? static_cast<double>(sum.first) / sum.meeting : 0.0);
  }
  for (const auto& beam : beams) {
    for (const Return& found : beam) {
      for (int axis = 0; axis < 3; ++axis) {
        scene.cloud.values.push_back(
            static_cast<float>(std::round(1000.0 * found.point[axis]) / 1000.0));
      }
      scene.cloud.values.push_back(static_cast<float>(std::round(100.0 * found.intensity) / 100.0));
      if (found.owner >= 0) ++scene.returns[found.owner];
    }
  }
  return scene;
}

}  // namespace arbox::testing
