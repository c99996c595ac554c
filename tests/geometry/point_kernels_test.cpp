#include "arbox/geometry/internal/point_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace arbox::geometry::internal;
using arbox::SimdLevel;

class PointKernelsOf : public ::testing::TestWithParam<SimdLevel> {
 protected:
  void SetUp() override {
    if (GetParam() > arbox::simd_level())
      GTEST_SKIP() << "this CPU (or ARBOX_SIMD) has no such level";
  }
};
INSTANTIATE_TEST_SUITE_P(Levels, PointKernelsOf,
                         ::testing::Values(SimdLevel::kScalar, SimdLevel::kAvx2,
                                           SimdLevel::kAvx512),
                         [](const auto& level) { return std::string(to_string(level.param)); });

struct Input {
  std::vector<double> x, y, z;
  std::vector<KernelBox> boxes;
};

/// Numbers that no product rounds, so that every level must agree to the bit.
Input make_input(std::size_t points, std::size_t boxes) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> whole(-64, 64);
  Input input;
  for (auto* axis : {&input.x, &input.y, &input.z}) {
    for (std::size_t i = 0; i < points; ++i) axis->push_back(whole(random) / 16.0);
  }
  for (std::size_t b = 0; b < boxes; ++b) {
    KernelBox box;
    for (double& value : box.axes) value = whole(random) / 64.0;
    for (double& value : box.offset) value = whole(random) / 32.0;
    for (double& value : box.half) value = 3 + whole(random) / 32.0;
    box.weight = 1 + b % 3;
    input.boxes.push_back(box);
  }
  return input;
}

double along(const double* row, const Input& input, std::size_t i) {
  return row[0] * input.x[i] + row[1] * input.y[i] + row[2] * input.z[i];
}

TEST_P(PointKernelsOf, OccupancyAddsTheWeightsOfTheBoxesThatHoldAPoint) {
  const Input input = make_input(4 * kPointPadding, 11);
  std::vector<double> result(input.x.size(), -1);
  point_kernels(GetParam())
      .occupancy(input.x.data(), input.y.data(), input.z.data(), input.x.size(), input.boxes.data(),
                 input.boxes.size(), result.data());
  double sum = 0;
  for (std::size_t i = 0; i < result.size(); ++i) {
    double expected = 0;
    for (const KernelBox& box : input.boxes) {
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        inside =
            inside && std::abs(along(box.axes + 3 * a, input, i) - box.offset[a]) <= box.half[a];
      }
      if (inside) expected += box.weight;
    }
    EXPECT_EQ(result[i], expected);
    sum += expected;
  }
  EXPECT_GT(sum, 0);
}

TEST_P(PointKernelsOf, ExtentsWiden) {
  const Input input = make_input(3 * kPointPadding, 5);
  std::vector<double> rotations, result;
  for (const KernelBox& box : input.boxes) {
    rotations.insert(rotations.end(), box.axes, box.axes + 9);
    const double infinity = std::numeric_limits<double>::infinity();
    result.insert(result.end(), {infinity, infinity, infinity, -infinity, -infinity, 100.0});
  }
  point_kernels(GetParam())
      .extents(input.x.data(), input.y.data(), input.z.data(), input.x.size(), rotations.data(),
               input.boxes.size(), result.data());
  for (std::size_t r = 0; r < input.boxes.size(); ++r) {
    for (int a = 0; a < 3; ++a) {
      std::vector<double> values;
      for (std::size_t i = 0; i < input.x.size(); ++i) {
        values.push_back(along(&rotations[9 * r + 3 * a], input, i));
      }
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      EXPECT_EQ(result[6 * r + a], *low);
      EXPECT_EQ(result[6 * r + 3 + a], a == 2 ? 100.0 : *high);
    }
  }
}

}  // namespace
