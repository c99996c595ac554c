#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "arbox/base/random.h"
#include "arbox/detectors/cluster_fit/internal/ground.h"

namespace arbox::detectors::internal {
namespace {

using Height = std::function<double(double, double)>;

/// Returns of a 40-ring scanner from a ground of that height.
std::vector<Eigen::Vector3f> ground_returns(const Height& height, double noise = 0.02) {
  const RandomStream draw(3, 0, 0);
  std::vector<Eigen::Vector3f> points;
  std::uint32_t next = 0;
  for (double radius = 4.0; radius < 60.0; radius *= 1.07) {
    for (double angle = -std::numbers::pi; angle < std::numbers::pi; angle += 0.01) {
      const double x = radius * std::cos(angle), y = radius * std::sin(angle);
      points.emplace_back(static_cast<float>(x), static_cast<float>(y),
                          static_cast<float>(height(x, y) + noise * draw.normal(next++)));
    }
  }
  return points;
}

void add_wall(std::vector<Eigen::Vector3f>& points, double x, double bottom) {
  for (double y = -12.0; y < 12.0; y += 0.1) {
    for (double z = bottom; z < bottom + 6.0; z += 0.2) {
      points.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    }
  }
}

double worst_error(const std::vector<Eigen::Vector3f>& points, const Height& height,
                   double from = 4.5, double to = 55.0) {
  const GroundSurface surface(points, {}, 80.0, 1);
  double worst = 0.0;
  for (double radius = from; radius < to; radius += 0.7) {
    for (double angle = 0.0; angle < 6.28; angle += 0.05) {
      const double x = radius * std::cos(angle), y = radius * std::sin(angle);
      worst = std::max(
          worst,
          std::abs(surface.height(static_cast<float>(x), static_cast<float>(y)) - height(x, y)));
    }
  }
  return worst;
}

TEST(GroundSurface, FollowsAPlaneOfAnySlope) {
  for (const double slope : {0.0, 0.05, 0.12, 0.2}) {
    for (double direction = 0.0; direction < 6.0; direction += 0.8) {
      const Height plane = [=](double x, double y) {
        return -1.73 + slope * (x * std::cos(direction) + y * std::sin(direction));
      };
      // A sector is 1.9 m wide at 55 m, and its lowest return is taken for its height.
      EXPECT_LT(worst_error(ground_returns(plane), plane), 0.12 + 0.45 * slope)
          << "slope " << slope << " towards " << direction;
    }
  }
}

TEST(GroundSurface, FollowsASlopeThatGrows) {
  const Height hill = [](double x, double) { return -1.73 + (x > 0 ? 0.0012 * x * x : 0.0); };
  EXPECT_LT(worst_error(ground_returns(hill), hill), 0.2);
}

TEST(GroundSurface, FollowsAKerb) {
  const Height street = [](double, double y) { return y > 5.0 ? -1.63 : -1.73; };
  EXPECT_LT(worst_error(ground_returns(street), street), 0.18);
}

TEST(GroundSurface, IsNotLiftedByWallsAndRoofs) {
  const Height flat = [](double, double) { return -1.73; };
  auto points = ground_returns(flat);
  add_wall(points, 10.0, -1.7);
  // A roof over all the ground behind: nothing lower is seen there.
  std::erase_if(points, [](const auto& p) {
    return p.x() > 10.5f && std::abs(p.y()) < 1.1f * p.x() && p.z() < -1.0f;
  });
  for (float x = 14.0f; x < 25.0f; x += 0.2f) {
    for (float y = -5.0f; y < 5.0f; y += 0.2f) points.emplace_back(x, y, 1.0f);
  }
  EXPECT_LT(worst_error(points, flat), 0.25);
}

TEST(GroundSurface, IsNotLoweredByGhostReturns) {
  const Height flat = [](double, double) { return -1.73; };
  auto points = ground_returns(flat);
  const RandomStream draw(9, 0, 0);
  for (std::uint32_t i = 0; i < 400; ++i) {
    points.emplace_back(static_cast<float>(draw.uniform(3 * i, -50, 50)),
                        static_cast<float>(draw.uniform(3 * i + 1, -50, 50)),
                        static_cast<float>(draw.uniform(3 * i + 2, -9, -2.2)));
  }
  EXPECT_LT(worst_error(points, flat), 0.2);
}

TEST(GroundSurface, OfFewPointsIsDefined) {
  EXPECT_EQ(GroundSurface({}, {}, 80.0, 1).height(5.0f, 5.0f), 0.0f);
  const std::vector<Eigen::Vector3f> one = {{3.0f, 4.0f, -2.0f}};
  EXPECT_NEAR(GroundSurface(one, {}, 80.0, 1).height(3.0f, 4.0f), -2.0, 0.01);
}

}  // namespace
}  // namespace arbox::detectors::internal
