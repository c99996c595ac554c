#include "arbox/sparse/point_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;

float squared(const float* a, const float* b) {
  const float dx = a[0] - b[0], dy = a[1] - b[1], dz = a[2] - b[2];
  return dx * dx + dy * dy + dz * dz;
}

std::vector<std::int32_t> naive_furthest(const std::vector<float>& points, std::int64_t count) {
  const std::size_t size = points.size() / 3;
  std::vector<float> distance(size, std::numeric_limits<float>::max());
  std::vector<std::int32_t> result = {0};
  while (static_cast<std::int64_t>(result.size()) < count) {
    for (std::size_t i = 0; i < size; ++i) {
      distance[i] = std::min(distance[i], squared(&points[3 * i], &points[3 * result.back()]));
    }
    result.push_back(static_cast<std::int32_t>(std::max_element(distance.begin(), distance.end()) -
                                               distance.begin()));
  }
  return result;
}

TEST(FurthestPoints, EqualTheNaiveSearch) {
  for (const std::size_t size : {5u, 16u, 33u, 1000u}) {
    const auto points = random_numbers(1, 3 * size);
    EXPECT_EQ(furthest_points(points, 5), naive_furthest(points, 5));
  }
  const auto points = random_numbers(2, 3 * 3001);
  EXPECT_EQ(furthest_points(points, 300), naive_furthest(points, 300));
}

TEST(FurthestPoints, TiesGoToTheLowestIndex) {
  std::vector<float> lattice;
  for (int i = 0; i < 343; ++i) {
    lattice.insert(lattice.end(), {float(i % 7), float(i / 7 % 7), float(i / 49)});
  }
  EXPECT_EQ(furthest_points(lattice, 60), naive_furthest(lattice, 60));
  const std::vector<float> same(3 * 40, 1.5f);
  EXPECT_EQ(furthest_points(same, 3), (std::vector<std::int32_t>{0, 0, 0}));
}

TEST(FurthestPoints, FewerPointsThanAskedRepeat) {
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 5, 0, 0};
  EXPECT_EQ(furthest_points(points, 7), (std::vector<std::int32_t>{0, 2, 1, 0, 2, 1, 0}));
  EXPECT_TRUE(furthest_points({}, 7).empty());
  EXPECT_TRUE(furthest_points(points, 0).empty());
}

TEST(FurthestPoints, RefuseWhatIsNoPoint) {
  std::vector<float> points = {0, 1, 2, 3, NAN, 5};
  EXPECT_THROW(furthest_points(points, 1), InvalidArgument);
  EXPECT_THROW(furthest_points(std::vector<float>(4), 1), InvalidArgument);
  EXPECT_THROW(furthest_points({}, -1), InvalidArgument);
}

std::vector<std::int32_t> naive_ball(const std::vector<float>& points,
                                     const std::vector<float>& centres, const BallQuery& query) {
  std::vector<std::int32_t> result;
  for (std::size_t c = 0; c < centres.size() / 3; ++c) {
    std::vector<std::pair<float, std::int32_t>> hits;
    for (std::size_t i = 0; i < points.size() / 3; ++i) {
      const float distance = squared(&points[3 * i], &centres[3 * c]);
      if (distance < query.radius * query.radius) {
        hits.push_back({query.rule == BallRule::kFirst ? 0 : distance, static_cast<int>(i)});
      }
    }
    std::sort(hits.begin(), hits.end());
    for (std::int32_t s = 0; s < query.samples; ++s) {
      const std::size_t at = s < static_cast<std::int32_t>(hits.size()) ? s : 0;
      result.push_back(hits.empty() ? -1 : hits[at].second);
    }
  }
  return result;
}

TEST(BallQuery, EqualsTheNaiveSearch) {
  const auto points = random_numbers(4, 3 * 2000), centres = random_numbers(5, 3 * 150);
  for (const float radius : {0.02f, 0.1f, 0.3f, 5.0f}) {
    for (const BallRule rule : {BallRule::kFirst, BallRule::kNearest}) {
      const BallQuery query{.radius = radius, .samples = 16, .rule = rule};
      EXPECT_EQ(ball_query(points, centres, query), naive_ball(points, centres, query));
      EXPECT_EQ(ball_query(points, centres, query, 1), ball_query(points, centres, query, 3));
    }
  }
}

TEST(BallQuery, CentresFarFromAllPointsFindNone) {
  const auto points = random_numbers(6, 30);
  const std::vector<float> centres = {100, 0, 0, -1e30f, 0, 0, 0, 1e30f, -1e30f};
  for (const std::int32_t index : ball_query(points, centres, {.radius = 0.5f, .samples = 2})) {
    EXPECT_EQ(index, -1);
  }
  EXPECT_EQ(ball_query({}, centres, {.samples = 2}), std::vector<std::int32_t>(6, -1));
  EXPECT_TRUE(ball_query(points, {}, {}).empty());
}

TEST(BallQuery, DuplicatesCountAndTheRadiusIsOpen) {
  const std::vector<float> points = {1, 0, 0, 1, 0, 0, 2, 0, 0};
  const std::vector<float> centre = {0, 0, 0};
  EXPECT_EQ(ball_query(points, centre, {.radius = 2, .samples = 3}),
            (std::vector<std::int32_t>{0, 1, 0}));
  EXPECT_EQ(ball_query(points, centre, {.radius = 1, .samples = 1}),
            (std::vector<std::int32_t>{-1}));
}

TEST(BallQuery, TinyRadiusOnAWideCloud) {
  const std::vector<float> points = {0, 0, 0, 1000, 1000, 1000, 1000, 1000, 1000.0001f};
  const BallQuery query{.radius = 1e-3f, .samples = 2};
  EXPECT_EQ(ball_query(points, points, query), naive_ball(points, points, query));
}

TEST(BallQuery, RefusesBadArguments) {
  const std::vector<float> one(3);
  EXPECT_THROW(ball_query(one, one, {.radius = 0}), InvalidArgument);
  EXPECT_THROW(ball_query(one, one, {.radius = NAN}), InvalidArgument);
  EXPECT_THROW(ball_query(one, one, {.samples = 0}), InvalidArgument);
  EXPECT_THROW(ball_query(std::vector<float>{1, 2, INFINITY}, one, {}), InvalidArgument);
}

TEST(BoxOfPoints, FindsTheLowestBoxAndRespectsRotation) {
  const double half = std::sqrt(0.5);
  // A long box turned by 90 degrees about z, and a large one around everything.
  const std::vector<double> boxes = {0, 0, 0, 4, 1, 1, half, 0,  0, half,
                                     0, 0, 0, 6, 6, 6, 2,    0., 0, 0};
  const std::vector<float> points = {0, 1.9f, 0, 1.9f, 0, 0, 0, 4, 0, 0.5f, -2, 0.5f, NAN, 0, 0};
  EXPECT_EQ(box_of_points(points, boxes), (std::vector<std::int32_t>{0, 1, -1, 1, -1}));
  EXPECT_EQ(box_of_points(points, boxes, 1.5), (std::vector<std::int32_t>{0, 0, 1, 0, -1}));
  EXPECT_EQ(box_of_points(points, {}), std::vector<std::int32_t>(5, -1));
  EXPECT_THROW(box_of_points(points, std::vector<double>(9)), InvalidArgument);
}

}  // namespace
