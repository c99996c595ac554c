#include "arbox/heads/internal/row_smoother.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace arbox::heads::internal {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

/// One bin that is sure.
std::vector<float> spike(std::size_t bins, std::size_t at) {
  std::vector<float> row(bins, kNothing);
  row[at] = 0.0f;
  return row;
}

std::vector<double> probabilities(const std::vector<float>& row) {
  std::vector<double> result;
  for (const float one : row) result.push_back(std::exp(one));
  return result;
}

double total(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(RowSmoother, SpreadsOneBinLikeAGaussianOfItsWidth) {
  for (const double wanted : {2.0, 8.0, 24.0}) {
    RowSmoother smoother(wanted);
    EXPECT_NEAR(smoother.standard_deviation(), wanted, 0.3);
    std::vector<float> row = spike(511, 255);
    smoother.smooth(row, false);
    const auto kernel = probabilities(row);
    EXPECT_NEAR(total(kernel), 1.0, 1e-6);
    const double width = smoother.standard_deviation();
    for (int i = 0; i < 511; ++i) {
      EXPECT_NEAR(kernel[i], kernel[510 - i], 1e-12);
      const double gaussian = std::exp(-0.5 * std::pow((i - 255) / width, 2)) /
                              (width * std::sqrt(2.0 * std::acos(-1.0)));
      EXPECT_NEAR(kernel[i], gaussian, 0.06 / width) << i << " of " << wanted;
    }
  }
}

TEST(RowSmoother, GoesRoundWhereARowIsCircular) {
  RowSmoother smoother(10.0);
  std::vector<float> round = spike(100, 1), open = round, middle = spike(100, 51);
  smoother.smooth(round, true);
  smoother.smooth(open, false);
  smoother.smooth(middle, true);
  EXPECT_NEAR(total(probabilities(round)), 1.0, 1e-6);
  EXPECT_LT(total(probabilities(open)), 0.6);
  for (int i = 0; i < 100; ++i) {
    EXPECT_NEAR(std::exp(round[i]), std::exp(middle[(i + 50) % 100]), 1e-6);
  }
}

TEST(RowSmoother, TakesKernelsWiderThanTheRow) {
  RowSmoother smoother(1000.0);
  std::vector<float> round = spike(7, 3), open = round;
  smoother.smooth(round, true);
  smoother.smooth(open, false);
  for (const float one : round) EXPECT_NEAR(std::exp(one), 1.0 / 7, 1e-3);
  for (const float one : open) EXPECT_TRUE(std::isfinite(one));
}

TEST(RowSmoother, LeavesRowsAloneWithoutAWidth) {
  RowSmoother smoother(0.0);
  std::vector<float> row = {-1.0f, -0.5f, kNothing}, none;
  smoother.smooth(row, true);
  EXPECT_EQ(row, (std::vector<float>{-1.0f, -0.5f, kNothing}));
  smoother.smooth(none, true);
  EXPECT_TRUE(none.empty());
}

TEST(RowSmoother, KeepsItsAnswersApart) {
  RowSmoother used(3.0), fresh(3.0);
  std::vector<float> before = spike(50, 5), first = spike(30, 9), second = first;
  used.smooth(before, true);
  used.smooth(first, false);
  fresh.smooth(second, false);
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace arbox::heads::internal
