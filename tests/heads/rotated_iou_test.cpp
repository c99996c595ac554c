#include "arbox/heads/rotated_iou.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <numbers>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"

namespace {

using namespace arbox;

using Row = std::array<double, 7>;

at::Tensor tensor_of(const std::vector<Row>& rows) {
  at::Tensor result = at::zeros({static_cast<std::int64_t>(rows.size()), 7}, at::kDouble);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy(rows[i].begin(), rows[i].end(), result.data_ptr<double>() + 7 * i);
  }
  return result;
}

double iou(const Row& first, const Row& second) {
  return heads::rotated_iou(tensor_of({first}), tensor_of({second})).item<double>();
}

struct Gradients {
  at::Tensor first, second;
};

Gradients gradients(const std::vector<Row>& first, const std::vector<Row>& second) {
  const at::Tensor a = tensor_of(first).requires_grad_(), b = tensor_of(second).requires_grad_();
  heads::rotated_iou(a, b).sum().backward();
  return {a.grad(), b.grad()};
}

/// Pairs that overlap by chance, at map coordinates.
std::vector<std::array<Row, 2>> generic_pairs(int count) {
  std::vector<std::array<Row, 2>> pairs;
  for (std::uint64_t object = 0; std::ssize(pairs) < count; ++object) {
    const RandomStream random(5, object, 0);
    const auto u = [&](std::uint32_t draw, double low, double high) {
      return random.uniform(draw, low, high);
    };
    Row a{}, b{};
    for (std::uint32_t k = 0; k < 2; ++k) {
      (k ? b : a) = {50 + u(10 * k, -1, 1), -20 + u(10 * k + 1, -1, 1), u(10 * k + 2, -0.5, 0.5),
                     u(10 * k + 3, 1, 5),   u(10 * k + 4, 0.5, 3),      u(10 * k + 5, 0.5, 3),
                     u(10 * k + 6, -4, 4)};
    }
    if (iou(a, b) > 0.01) pairs.push_back({a, b});
  }
  return pairs;
}

TEST(RotatedIou, EqualsTheExactOverlap) {
  for (const auto& [a, b] : generic_pairs(300)) {
    const auto box = [](const Row& r) {
      return geometry::make_yaw_box({r[0], r[1], r[2]}, {r[3], r[4], r[5]}, r[6]);
    };
    EXPECT_NEAR(iou(a, b), geometry::overlap(box(a), box(b)), 1e-12);
  }
}

TEST(RotatedIou, GradientEqualsCentralDifferences) {
  constexpr double kStep = 1e-6;
  for (const auto& [a, b] : generic_pairs(1000)) {
    const Gradients exact = gradients({a}, {b});
    for (int side = 0; side < 2; ++side) {
      for (std::size_t i = 0; i < 7; ++i) {
        std::array<Row, 2> up = {a, b}, down = {a, b};
        up[side][i] += kStep;
        down[side][i] -= kStep;
        const double slope = (iou(up[0], up[1]) - iou(down[0], down[1])) / (2 * kStep);
        const double given =
            (side ? exact.second : exact.first)[0][static_cast<std::int64_t>(i)].item<double>();
        ASSERT_NEAR(given, slope, 1e-6) << "box " << side << ", parameter " << i;
      }
    }
  }
}

/// The gradient must be finite and between the one-sided differences, whichever of them is larger.
void expect_between_one_sided(const Row& a, const Row& b) {
  constexpr double kStep = 1e-7, kSlack = 1e-5;
  const Gradients given = gradients({a}, {b});
  const double here = iou(a, b);
  for (int side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < 7; ++i) {
      std::array<Row, 2> up = {a, b}, down = {a, b};
      up[side][i] += kStep;
      down[side][i] -= kStep;
      const double right = (iou(up[0], up[1]) - here) / kStep;
      const double left = (here - iou(down[0], down[1])) / kStep;
      const double slope =
          (side ? given.second : given.first)[0][static_cast<std::int64_t>(i)].item<double>();
      EXPECT_GE(slope, std::min(left, right) - kSlack) << "box " << side << ", parameter " << i;
      EXPECT_LE(slope, std::max(left, right) + kSlack) << "box " << side << ", parameter " << i;
    }
  }
}

TEST(RotatedIou, GradientIsASubgradientAtCoincidentAndTouchingPairs) {
  const double pi = std::numbers::pi;
  const Row box = {1, 2, 3, 4, 2, 1, 0.3};
  expect_between_one_sided(box, box);
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {0, 0, 0, 4, 2, 1, 0});
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {0, 0, 0, 4, 2, 1, pi});
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {0, 0, 0, 2, 4, 1, 0.5 * pi});
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {1, 0, 0, 2, 2, 1, 0});       // shared faces
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {0, 0, 0.25, 4, 2, 0.5, 0});  // shared top
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {4, 0, 0, 4, 2, 1, 0});       // side by side
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {4, 2, 0, 4, 2, 1, 0});       // edge to edge
  expect_between_one_sided({0, 0, 0, 4, 2, 1, 0}, {0, 0, 1, 4, 2, 1, 0});       // stacked
  expect_between_one_sided({0, 0, 0, 2, 2, 1, 0},
                           {1 + std::numbers::sqrt2, 0, 0, 2, 2, 1, 0.25 * pi});  // corner on face
}

TEST(RotatedIou, CoincidentBoxesAreAtTheTop) {
  const Gradients given = gradients({{1, 2, 3, 4, 2, 1, 0.3}}, {{1, 2, 3, 4, 2, 1, 0.3}});
  EXPECT_LT(given.first.abs().max().item<double>(), 1e-12);
  EXPECT_DOUBLE_EQ(iou({1, 2, 3, 4, 2, 1, 0.3}, {1, 2, 3, 4, 2, 1, 0.3}), 1.0);
}

TEST(RotatedIou, DisjointAndEmptyBoxesHaveNoOverlapAndNoGradient) {
  const std::vector<Row> first = {
      {0, 0, 0, 4, 2, 1, 0}, {0, 0, 0, 4, 2, 1, 0}, {0, 0, 0, 0, 2, 1, 0}};
  const std::vector<Row> second = {
      {9, 0, 0, 4, 2, 1, 1}, {0, 0, 5, 4, 2, 1, 1}, {0, 0, 0, 4, 2, 1, 0}};
  const Gradients given = gradients(first, second);
  EXPECT_EQ(heads::rotated_iou(tensor_of(first), tensor_of(second)).abs().max().item<double>(), 0);
  EXPECT_EQ(given.first.abs().max().item<double>(), 0);
  EXPECT_EQ(given.second.abs().max().item<double>(), 0);
}

TEST(RotatedIou, KeepsShapeAndTypeAndRefusesOthers) {
  const at::Tensor none = at::zeros({0, 3, 7});
  EXPECT_EQ(heads::rotated_iou(none, none).sizes(), (std::vector<std::int64_t>{0, 3}));
  EXPECT_EQ(heads::rotated_iou(none, none).scalar_type(), at::kFloat);
  EXPECT_THROW(heads::rotated_iou(none, at::zeros({1, 3, 7})), InvalidArgument);
  EXPECT_THROW(heads::rotated_iou(at::zeros({2, 10}), at::zeros({2, 10})), InvalidArgument);
}

}  // namespace
