#include "arbox/drawing/internal/projection.h"

#include <gtest/gtest.h>

namespace arbox::drawing {
namespace {

// Looks along +x from the origin: x right is -y, y down is -z.
Projection forward_camera() {
  Projection projection;
  projection.matrix << 500, -1000, 0, 0, 500, 0, -1000, 0, 1, 0, 0, 0;
  projection.near = 0.1;
  return projection;
}

std::vector<Eigen::Vector3d> box_corners(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1 ? high : low).x(), (i & 2 ? high : low).y(),
                         (i & 4 ? high : low).z());
  }
  return corners;
}

TEST(Projection, BirdseyeHasForwardUpAndLeftToTheLeft) {
  const Rect rect = {100, 200, 300, 400};
  const Projection projection = birdseye_projection({10, 5, 0}, 4.0, rect);
  EXPECT_TRUE(projection({10, 5, 3})->isApprox(Point(200, 300)));
  EXPECT_TRUE(projection({11, 5, 3})->isApprox(Point(200, 296)));
  EXPECT_TRUE(projection({10, 6, 3})->isApprox(Point(196, 300)));
}

TEST(Projection, PerspectiveShowsTheWholeRegionAndFillsTheRectangle) {
  const Rect rect = {50, 20, 850, 620};
  const Eigen::Vector3d low(-5, -30, -2), high(60, 20, 4);
  const std::vector<Eigen::Vector3d> shown = box_corners(low, high);
  for (const double azimuth : {-160.0, 0.0, 35.0, 90.0, 180.0}) {
    for (const double elevation : {5.0, 28.0, 85.0}) {
      const Projection projection = perspective_projection(shown, azimuth, elevation, rect);
      Point first(1e9, 1e9), last(-1e9, -1e9);
      for (const Eigen::Vector3d& point : shown) {
        const auto pixel = projection(point);
        ASSERT_TRUE(pixel.has_value());
        first = first.cwiseMin(*pixel);
        last = last.cwiseMax(*pixel);
      }
      EXPECT_GE(first.x(), rect.left - 1e-6);
      EXPECT_GE(first.y(), rect.top - 1e-6);
      EXPECT_LE(last.x(), rect.right + 1e-6);
      EXPECT_LE(last.y(), rect.bottom + 1e-6);
      const double filled =
          std::max((last.x() - first.x()) / rect.width(), (last.y() - first.y()) / rect.height());
      EXPECT_GT(filled, 0.9) << azimuth << " " << elevation;
    }
  }
}

TEST(Projection, OnePointIsShownInTheMiddle) {
  const std::vector<Eigen::Vector3d> shown = {{3, 4, 5}};
  const Projection projection = perspective_projection(shown, 10.0, 20.0, {0, 0, 100, 60});
  const auto pixel = projection({3, 4, 5});
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 50.0, 1e-6);
  EXPECT_NEAR(pixel->y(), 30.0, 1e-6);
}

TEST(Projection, PerspectiveIsUprightAndNotMirrored) {
  const Projection projection =
      perspective_projection(box_corners({-1, -1, -1}, {1, 1, 1}), 180.0, 20.0, {0, 0, 100, 100});
  EXPECT_LT(projection({0, 0, 1})->y(), projection({0, 0, -1})->y());
  EXPECT_LT(projection({0, 1, 0})->x(), projection({0, -1, 0})->x());
}

TEST(Projection, WhatIsBehindTheCameraIsGone) {
  const Projection projection = forward_camera();
  EXPECT_FALSE(projection({-5, 0, 0}).has_value());
  EXPECT_FALSE(projection.segment({-5, 0, 0}, {-1, 2, 0}).has_value());
  EXPECT_TRUE(projection.polygon({{-5, 0, 0}, {-5, 1, 0}, {-5, 1, 1}}).empty());
}

TEST(Projection, ASegmentThroughTheCameraPlaneEndsAtTheNearPlane) {
  const Projection projection = forward_camera();
  const auto segment = projection.segment({-10, -2, -1}, {10, -2, -1});
  ASSERT_TRUE(segment.has_value());
  EXPECT_TRUE(segment->second.isApprox(Point(700, 600)));
  EXPECT_TRUE(segment->first.isApprox(Point(500 + 2000 / 0.1, 500 + 1000 / 0.1)));
  const auto reversed = projection.segment({10, -2, -1}, {-10, -2, -1});
  EXPECT_TRUE(reversed->first.isApprox(segment->second));
  EXPECT_TRUE(reversed->second.isApprox(segment->first));
}

TEST(Projection, APolygonIsCutAtTheNearPlane) {
  const auto cut = forward_camera().polygon({{-1, -1, -1}, {9, -1, -1}, {9, 1, -1}, {-1, 1, -1}});
  ASSERT_EQ(cut.size(), 4u);
  for (const Point& p : cut) EXPECT_GT(p.y(), 500.0);
}

}  // namespace
}  // namespace arbox::drawing
