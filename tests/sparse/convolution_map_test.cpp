#include "arbox/sparse/convolution_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "arbox/base/cpu.h"
#include "arbox/sparse/coordinate_manager.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;

struct Case {
  std::int32_t in_channels, out_channels;
  Kernel kernel = {};
  Lattice lattice = {};
  std::size_t voxels = 300;
};

/// A convolution with its inputs, and the sums that its definition asks for, in double.
struct Problem {
  explicit Problem(const Case& test)
      : in_channels(test.in_channels), out_channels(test.out_channels) {
    const bool bounded = test.lattice.grid.has_value();
    const auto set = std::make_shared<const CoordinateSet>(
        random_voxels(11, test.voxels, 2, bounded ? 0 : -4, 8), test.lattice);
    connection = manager.convolution(set, test.kernel);
    input = random_numbers(12, set->size() * in_channels);
    weight = random_numbers(13, map().elements() * in_channels * out_channels);
    gradient = random_numbers(14, connection.outputs->size() * out_channels);
  }

  const KernelMap& map() const { return *connection.map; }
  MapRows rows() const {
    return {connection.inputs->sorted().rows, connection.outputs->sorted().rows};
  }

  template <class Visit>
  void for_each_pair(Visit visit) const {
    for (std::int64_t k = 0; k < map().elements(); ++k) {
      for (std::int64_t p = map().starts[k]; p < map().starts[k + 1]; ++p) {
        visit(k, rows().inputs[map().inputs[p]], rows().outputs[map().outputs[p]]);
      }
    }
  }

  template <class Visit>
  void for_each_product(Visit visit) const {
    for_each_pair([&](std::int64_t k, std::int64_t i, std::int64_t o) {
      for (std::int64_t a = 0; a < in_channels; ++a) {
        for (std::int64_t b = 0; b < out_channels; ++b) {
          visit(i * in_channels + a, (k * in_channels + a) * out_channels + b,
                o * out_channels + b);
        }
      }
    });
  }

  std::vector<double> forward() const {
    std::vector<double> sums(gradient.size(), 0.0);
    for_each_product([&](auto i, auto w, auto o) { sums[o] += double{input[i]} * weight[w]; });
    return sums;
  }
  std::vector<double> input_gradient() const {
    std::vector<double> sums(input.size(), 0.0);
    for_each_product([&](auto i, auto w, auto o) { sums[i] += double{gradient[o]} * weight[w]; });
    return sums;
  }
  std::vector<double> weight_gradient() const {
    std::vector<double> sums(weight.size(), 0.0);
    for_each_product([&](auto i, auto w, auto o) { sums[w] += double{gradient[o]} * input[i]; });
    return sums;
  }

  std::vector<float> run_forward(const Epilogue& epilogue = {}, int threads = 0) const {
    std::vector<float> output(gradient.size(), NAN);
    convolve(map(), rows(), input.data(), weight.data(), in_channels, out_channels, output.data(),
             epilogue, threads);
    return output;
  }
  std::vector<float> run_input_gradient(int threads = 0) const {
    std::vector<float> result(input.size(), NAN);
    convolve_input_gradient(map(), rows(), gradient.data(), weight.data(), in_channels,
                            out_channels, result.data(), threads);
    return result;
  }
  std::vector<float> run_weight_gradient(int threads = 0) const {
    std::vector<float> result(weight.size(), NAN);
    convolve_weight_gradient(map(), rows(), input.data(), gradient.data(), in_channels,
                             out_channels, result.data(), threads);
    return result;
  }

  std::int32_t in_channels, out_channels;
  CoordinateManager manager;
  Connection connection;
  std::vector<float> input, weight, gradient;
};

void expect_close(const std::vector<float>& got, const std::vector<double>& expected) {
  ASSERT_EQ(got.size(), expected.size());
  double largest = 1e-30, worst = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    largest = std::max(largest, std::abs(expected[i]));
    const double error = std::abs(got[i] - expected[i]);
    worst = std::isnan(error) ? INFINITY : std::max(worst, error);
  }
  EXPECT_LE(worst, 1e-5 * largest) << "at level " << to_string(simd_level());
}

class ConvolutionMap : public ::testing::TestWithParam<Case> {};

TEST_P(ConvolutionMap, EqualsTheSumInDouble) {
  const Problem problem(GetParam());
  expect_close(problem.run_forward(), problem.forward());
  expect_close(problem.run_input_gradient(), problem.input_gradient());
  expect_close(problem.run_weight_gradient(), problem.weight_gradient());
}

TEST_P(ConvolutionMap, HasTheSameBytesAtAnyThreadCount) {
  const Problem problem(GetParam());
  EXPECT_EQ(problem.run_forward({}, 1), problem.run_forward({}, 3));
  EXPECT_EQ(problem.run_input_gradient(1), problem.run_input_gradient(3));
  EXPECT_EQ(problem.run_weight_gradient(1), problem.run_weight_gradient(3));
}

std::vector<Case> cases() {
  std::vector<Case> result;
  for (const std::int32_t channels : {1, 2, 3, 4, 7, 8, 15, 16, 17, 31, 32, 48, 64, 100, 128}) {
    result.push_back({channels, channels});
  }
  const Lattice grid{.grid = Triple{8, 9, 10}};
  result.push_back({1, 256, {}, {}, 40});
  result.push_back({256, 1, {}, {}, 40});
  result.push_back({256, 256, {}, {}, 40});
  result.push_back({3, 64, {.stride = {2, 2, 2}}});
  result.push_back({64, 5, {.size = {2, 2, 2}, .stride = {2, 2, 2}}});
  result.push_back({33, 47, {.size = {1, 1, 1}, .stride = {2, 2, 2}}});
  result.push_back({128, 18, {.size = {1, 1, 1}}});
  result.push_back({16, 32, {.size = {3, 1, 5}, .dilation = {1, 2, 1}}});
  result.push_back({16, 32, {.stride = {2, 2, 2}, .padding = {1, 1, 1}}, grid});
  result.push_back({64, 128, {.size = {1, 1, 3}, .stride = {1, 1, 2}}, grid});
  result.push_back({16, 16, {.submanifold = true}, grid});
  result.push_back({16, 16, {}, {}, 0});
  result.push_back({16, 16, {}, {}, 1});
  // Many tiles and ranges of outputs.
  result.push_back({5, 20, {.size = {1, 3, 1}}, {}, 1024});
  return result;
}

INSTANTIATE_TEST_SUITE_P(Shapes, ConvolutionMap, ::testing::ValuesIn(cases()));

TEST(ConvolutionMapEpilogue, ScalesShiftsAddsAndRectifies) {
  for (const std::int32_t channels : {3, 16, 130}) {
    const Problem problem({.in_channels = 8, .out_channels = channels});
    const auto scale = random_numbers(21, channels);
    const auto shift = random_numbers(22, channels);
    const auto residual = random_numbers(23, problem.gradient.size());
    std::vector<double> expected = problem.forward();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const std::size_t c = i % channels;
      expected[i] = std::max(0.0, expected[i] * scale[c] + shift[c] + residual[i]);
    }
    expect_close(problem.run_forward(
                     {.scale = scale, .shift = shift, .residual = residual.data(), .relu = true}),
                 expected);
  }
}

TEST(ConvolutionMapEpilogue, ReachesOutputsWithoutPairs) {
  KernelMap map;
  map.starts = {0, 0};
  const std::vector<std::int32_t> rows = {1, 0};
  const std::vector<float> shift = {2, 3};
  const float weight[2] = {1, 1};
  std::vector<float> output(4, NAN);
  convolve(map, {.inputs = {}, .outputs = rows}, nullptr, weight, 1, 2, output.data(),
           {.shift = shift});
  EXPECT_EQ(output, (std::vector<float>{2, 3, 2, 3}));
}

}  // namespace
