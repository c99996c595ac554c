#include "arbox/heads/internal/mlp_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "arbox/base/cpu.h"
#include "heads/random_network.h"

namespace arbox::heads::internal {
namespace {

struct Level {
  SimdLevel level;
  MlpKernels kernels;
};

/// The instruction sets that this CPU has, or as many as ARBOX_SIMD allows.
std::vector<Level> levels() {
  std::vector<Level> all{
      {SimdLevel::kScalar,
       {scalar::panel_columns, scalar::layer, scalar::add_prefix, scalar::largest,
        scalar::exponentials}},
      {SimdLevel::kAvx2,
       {avx2::panel_columns, avx2::layer, avx2::add_prefix, avx2::largest, avx2::exponentials}},
      {SimdLevel::kAvx512,
       {avx512::panel_columns, avx512::layer, avx512::add_prefix, avx512::largest,
        avx512::exponentials}}};
  std::erase_if(all, [](const Level& one) { return one.level > simd_level(); });
  return all;
}

/// Columns of one layer, row-major (in, columns), in panels.
std::vector<float> in_panels(const std::vector<float>& weight, int in, int columns, int panel) {
  std::vector<float> packed;
  for (int first = 0; first < columns; first += panel) {
    for (int k = 0; k < in; ++k) {
      for (int j = 0; j < panel; ++j) packed.push_back(weight[k * columns + first + j]);
    }
  }
  return packed;
}

TEST(MlpKernel, LayerIsTheProductWithBiasAndRectifier) {
  for (const Level& one : levels()) {
    for (const int rows : {1, 2, 5, 6, 7, 23}) {
      for (const int in : {1, 7, 256, 300}) {
        const int columns = 128, stride = in + 3;
        const auto weight = testing::normal_floats(in * columns, 1, 1.0 / std::sqrt(in));
        const auto bias = testing::normal_floats(columns, 2, 1.0);
        const auto input = testing::normal_floats(rows * stride, 3, 1.0);
        const auto packed = in_panels(weight, in, columns, one.kernels.panel_columns());
        std::vector<float> output(rows * columns, -7.0f);
        one.kernels.layer({.input = input.data(),
                           .input_stride = stride,
                           .output = output.data(),
                           .output_stride = columns,
                           .rows = rows,
                           .weight = packed.data(),
                           .bias = bias.data(),
                           .in = in,
                           .columns = columns,
                           .leak = 0.25f});
        for (int r = 0; r < rows; ++r) {
          for (int c = 0; c < columns; ++c) {
            double sum = bias[c];
            for (int k = 0; k < in; ++k) sum += input[r * stride + k] * weight[k * columns + c];
            ASSERT_NEAR(output[r * columns + c], sum > 0 ? sum : 0.25 * sum, 2e-5)
                << to_string(one.level) << " rows " << rows << " in " << in;
          }
        }
      }
    }
  }
}

TEST(MlpKernel, ARowDoesNotDependOnTheOthers) {
  const int in = 300, columns = 128, rows = 23;
  const auto bias = testing::normal_floats(columns, 2, 1.0);
  const auto input = testing::normal_floats(rows * in, 3, 1.0);
  for (const Level& one : levels()) {
    const auto packed = in_panels(testing::normal_floats(in * columns, 1, 0.1), in, columns,
                                  one.kernels.panel_columns());
    const auto run = [&](int first, int count) {
      std::vector<float> output(count * columns);
      one.kernels.layer({.input = input.data() + first * in,
                         .input_stride = in,
                         .output = output.data(),
                         .output_stride = columns,
                         .rows = count,
                         .weight = packed.data(),
                         .bias = bias.data(),
                         .in = in,
                         .columns = columns,
                         .leak = 0.1f});
      return output;
    };
    const auto together = run(0, rows);
    for (int r = 0; r < rows; ++r) {
      const auto alone = run(r, 1);
      EXPECT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + r * columns))
          << to_string(one.level) << " row " << r;
    }
  }
}

TEST(MlpKernel, PrefixColumnsAreAddedToTheBase) {
  const auto base = testing::normal_floats(64, 1, 1.0);
  const auto columns = testing::normal_floats(3 * 64, 2, 1.0);
  const float values[] = {0.5f, -2.0f, 1.25f};
  for (const Level& one : levels()) {
    std::vector<float> output(64);
    one.kernels.add_prefix({base.data(), values, 3, columns.data(), 64, 0.1f, output.data()});
    for (int c = 0; c < 64; ++c) {
      const double sum =
          base[c] + 0.5 * columns[c] - 2.0 * columns[64 + c] + 1.25 * columns[128 + c];
      EXPECT_NEAR(output[c], sum > 0 ? sum : 0.1 * sum, 1e-5) << to_string(one.level);
    }
  }
}

TEST(MlpKernel, ExponentialsAreExactToAFewUnitsInTheLastPlace) {
  const int columns = 1024;
  std::vector<float> logits(columns), values(columns), sums(columns / kColumnBlock);
  for (int c = 0; c < columns; ++c) logits[c] = 3.0f - 0.099f * static_cast<float>(c);
  for (const Level& one : levels()) {
    EXPECT_EQ(one.kernels.largest(logits.data(), columns), 3.0f);
    one.kernels.exponentials(logits.data(), columns, 3.0f, 0.5f, values.data(), sums.data());
    double block = 0.0;
    for (int c = 0; c < columns; ++c) {
      const float argument = (logits[c] - 3.0f) * 0.5f;
      const double expected = argument > -87.0f ? std::exp(double{argument}) : 0.0;
      EXPECT_NEAR(values[c], expected, 2.5e-7 * expected) << to_string(one.level) << " " << c;
      block += values[c];
      if ((c + 1) % kColumnBlock == 0) {
        EXPECT_NEAR(sums[c / kColumnBlock], block, 1e-6 * block);
        block = 0.0;
      }
    }
  }
}

TEST(MlpKernel, ExponentialsOfNoMassAndOfNoNumberAreZero) {
  std::vector<float> logits(64, -1e30f), values(64), sums(1);
  logits[5] = 2.0f;
  logits[6] = std::nanf("");
  for (const Level& one : levels()) {
    one.kernels.exponentials(logits.data(), 64, 2.0f, 1e30f, values.data(), sums.data());
    EXPECT_EQ(sums[0], 1.0f) << to_string(one.level);
    EXPECT_EQ(values[5], 1.0f);
    EXPECT_EQ(values[6], 0.0f);
  }
}

}  // namespace
}  // namespace arbox::heads::internal
