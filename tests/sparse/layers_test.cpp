#include "arbox/sparse/layers.h"

#include <ATen/TensorIndexing.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/_unique.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/grid_sampler_2d.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/rand.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/where.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "arbox/base/error.h"
#include "arbox/sparse/point_sets.h"
#include "arbox/sparse/set_abstraction.h"
#include "sparse/expect_close.h"
#include "sparse/gradient_check.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;

SparseTensor random_tensor(std::int64_t channels, std::size_t voxels = 200,
                           std::int64_t batches = 2, at::ScalarType type = at::kFloat) {
  return SparseTensor(
      to_tensor(random_voxels(5, voxels, static_cast<std::int32_t>(batches), -5, 10)),
      at::randn({std::int64_t(voxels), channels}, type), {}, batches);
}

std::set<std::string> names(const torch::nn::Module& module) {
  std::set<std::string> result;
  for (const auto& item : module.named_parameters()) result.insert(item.key());
  for (const auto& item : module.named_buffers()) result.insert(item.key());
  return result;
}

void randomize(torch::nn::Module& module) {
  const at::NoGradGuard no_gradient;
  for (auto& parameter : module.parameters()) parameter.copy_(at::randn(parameter.sizes()) * 0.3);
  for (auto& item : module.named_buffers()) {
    if (item.key().ends_with("running_mean")) item.value().copy_(at::randn(item.value().sizes()));
    if (item.key().ends_with("running_var")) {
      item.value().copy_(at::rand(item.value().sizes()) + 0.5);
    }
  }
}

TEST(BatchNorm, NormalisesActiveVoxelsAndFolds) {
  BatchNorm norm(6);
  const at::Tensor x = at::randn({50, 6}) * 3 + 2;
  const at::Tensor y = norm.forward(x);
  expect_close(y, (x - x.mean(0)) / (x.var(0, false) + 1e-5).sqrt());
  norm.eval();
  const auto [scale, shift] = norm.folded();
  expect_close(norm.forward(x), x * scale + shift);
  EXPECT_EQ(norm.named_buffers()["num_batches_tracked"].item<int>(), 1);
}

TEST(BatchNorm, NoneAndOneRowLeaveStatisticsAlone) {
  BatchNorm norm(3);
  EXPECT_EQ(norm.forward(at::zeros({0, 3})).size(0), 0);
  EXPECT_TRUE(norm.forward(at::ones({1, 3})).isfinite().all().item<bool>());
  EXPECT_EQ(norm.named_buffers()["running_mean"].abs().sum().item<float>(), 0);
}

TEST(InstanceNorm, NormalisesEachSceneByItself) {
  const SparseTensor input = random_tensor(4, 300, 3, at::kDouble);
  InstanceNorm norm(4);
  norm.to(at::kDouble);
  randomize(norm);
  const at::Tensor weight = norm.named_parameters()["weight"],
                   bias = norm.named_parameters()["bias"];
  const SparseTensor output = norm.forward(input);
  for (std::int64_t scene = 0; scene < 3; ++scene) {
    const at::Tensor rows = input.batch_numbers() == scene;
    const at::Tensor x = input.features().index({rows});
    expect_close(output.features().index({rows}),
                 (x - x.mean(0)) / (x.var(0, false) + 1e-8).sqrt() * weight + bias, 1e-9);
  }
  const SparseTensor single = random_tensor(4, 60, 1, at::kDouble);
  const at::Tensor x = single.features();
  expect_close(norm.forward(single).features(),
               (x - x.mean(0)) / (x.var(0, false) + 1e-8).sqrt() * weight + bias, 1e-9);
  expect_gradients({input.features()}, [&](const auto& in) {
    return norm.forward(input.with_features(in[0])).features();
  });
}

TEST(ResidualBlock, HasTheNamesOfPublishedCheckpoints) {
  const ResidualBlock block(64, 128, 2);
  const std::set<std::string> expected = {"conv1.kernel",
                                          "conv2.kernel",
                                          "norm1.bn.weight",
                                          "norm1.bn.bias",
                                          "norm1.bn.running_mean",
                                          "norm1.bn.running_var",
                                          "norm1.bn.num_batches_tracked",
                                          "norm2.bn.weight",
                                          "norm2.bn.bias",
                                          "norm2.bn.running_mean",
                                          "norm2.bn.running_var",
                                          "norm2.bn.num_batches_tracked",
                                          "downsample.0.kernel",
                                          "downsample.1.bn.weight",
                                          "downsample.1.bn.bias",
                                          "downsample.1.bn.running_mean",
                                          "downsample.1.bn.running_var",
                                          "downsample.1.bn.num_batches_tracked"};
  EXPECT_EQ(names(block), expected);
  EXPECT_EQ(block.named_parameters()["downsample.0.kernel"].sizes(),
            (std::vector<std::int64_t>{1, 64, 128}));
  EXPECT_EQ(names(ResidualBlock(64, 64)).size(), 12u);
}

TEST(ResidualBlock, FoldedInferenceEqualsTheLayers) {
  for (const std::int32_t stride : {1, 2}) {
    ResidualBlock block(16, stride == 1 ? 16 : 32, stride);
    randomize(block);
    block.eval();
    const SparseTensor input = random_tensor(16);
    const at::Tensor layered = block.forward(input).features().detach();
    const at::NoGradGuard no_gradient;
    expect_close(block.forward(input).features(), layered);
  }
}

TEST(ResidualBlock, TrainsEveryParameter) {
  ResidualBlock block(8, 12, 2);
  const SparseTensor output = block.forward(random_tensor(8));
  output.features().square().sum().backward();
  for (const auto& item : block.named_parameters()) {
    EXPECT_GT(item.value().grad().abs().sum().item<float>(), 0) << item.key();
  }
}

TEST(GridConvolution, ReadsSpconvWeights) {
  const Kernel kernel{.size = {3, 1, 2}, .padding = {1, 0, 0}};
  GridConvolution layer(3, 5, kernel, true);
  randomize(layer);
  const SparseTensor input(to_tensor(random_voxels(5, 50, 1, 0, 6)), at::randn({50, 3}),
                           {.grid = Triple{6, 6, 6}});
  const at::Tensor weight = layer.named_parameters()["weight"];
  EXPECT_EQ(weight.sizes(), (std::vector<std::int64_t>{5, 2, 1, 3, 3}));
  at::Tensor elements = at::zeros({6, 3, 5});
  for (int z = 0; z < 2; ++z) {
    for (int x = 0; x < 3; ++x) {
      elements[x + 3 * z] = weight.detach().select(1, z).select(1, 0).select(1, x).t();
    }
  }
  const at::Tensor bias = layer.named_parameters()["bias"].detach();
  const at::Tensor expected = convolution(input, elements, kernel, bias).features();
  expect_close(layer.forward(input).features().detach(), expected);
  expect_close(layer.forward_fused(input, {}).features(), expected);
}

TEST(Convolution, BiasIsFoldedBelowTheScale) {
  Convolution layer(4, 6, {}, true);
  randomize(layer);
  const SparseTensor input = random_tensor(4);
  const at::Tensor scale = at::randn({6}), shift = at::randn({6});
  expect_close(
      layer.forward_fused(input, {.scale = scale, .shift = shift, .residual = {}}).features(),
      layer.forward(input).features().detach() * scale + shift);
  EXPECT_EQ(Convolution(4, 6, {.size = {1, 1, 1}}).weight().dim(), 2);
}

TEST(Activations, KeepCoordinates) {
  const SparseTensor input = random_tensor(3);
  EXPECT_EQ(relu(input).set(), input.set());
  EXPECT_GE(elu(input).features().min().item<float>(), -1);
}

at::Tensor points(std::int64_t count) { return at::rand({count, 3}) * 4; }

TEST(PointSets, BallQueryKeepsScenesApart) {
  const at::Tensor from = points(300), around = points(40);
  const std::vector<std::int64_t> point_counts = {100, 0, 200}, centre_counts = {15, 5, 20};
  const BallQuery query{.radius = 0.9f, .samples = 8};
  const at::Tensor index = ball_query(from, around, query, point_counts, centre_counts);
  EXPECT_TRUE((index.slice(0, 15, 20) == -1).all().item<bool>());
  const at::Tensor first = ball_query(from.slice(0, 0, 100), around.slice(0, 0, 15), query);
  EXPECT_TRUE(index.slice(0, 0, 15).equal(first));
  const at::Tensor last = ball_query(from.slice(0, 100), around.slice(0, 20), query);
  EXPECT_TRUE(index.slice(0, 20).equal(at::where(last < 0, last, last + 100)));
  EXPECT_THROW(ball_query(from, around, query, point_counts, {}), InvalidArgument);
}

TEST(PointSets, GroupGathersAndItsGradients) {
  const at::Tensor features = at::randn({10, 3}, at::kDouble);
  const at::Tensor index = at::tensor({0, 3, 3, -1, -1, 9}, at::kLong).view({3, 2});
  const at::Tensor grouped = group(features, index);
  expect_close(grouped[0][1], features[3], 0);
  EXPECT_EQ(grouped[1][1].abs().sum().item<double>(), 0);
  expect_gradients({features}, [&](const auto& in) { return group(in[0], index); });
  EXPECT_EQ(group(at::zeros({0, 3}), at::zeros({2, 2}, at::kLong) - 1).abs().sum().item<float>(),
            0);
}

TEST(PointSets, BirdsEyeSamplesAreBilinearInsideAndVanishAtTheFarBorder) {
  const at::Tensor map = at::randn({2, 3, 6, 7}, at::kDouble);
  const at::Tensor places =
      at::cat({at::ones({50, 1}), at::rand({50, 1}) * 5.9, at::rand({50, 1}) * 4.9}, 1)
          .to(at::kDouble);
  const at::Tensor x = places.select(1, 1) / 6 * 2 - 1, y = places.select(1, 2) / 5 * 2 - 1;
  const at::Tensor grid = at::cat({x.unsqueeze(1), y.unsqueeze(1)}, 1).view({1, 1, 50, 2});
  const at::Tensor expected =
      at::grid_sampler_2d(map.slice(0, 1, 2), grid, 0, 0, true).view({3, 50}).t();
  expect_close(sample_birds_eye(map, places), expected, 1e-10);
  const at::Tensor border = at::tensor({0.0, 6.0, 2.0, 0.0, 3.0, 5.0, 0.0, 9.0, 1.0}).view({3, 3});
  EXPECT_EQ(sample_birds_eye(map, border).abs().sum().item<double>(), 0);
  expect_gradients({map}, [&](const auto& in) { return sample_birds_eye(in[0], places); });
  EXPECT_THROW(sample_birds_eye(map, at::tensor({2.0, 0.0, 0.0}).view({1, 3})), InvalidArgument);
}

TEST(PointSets, RoiGridTurnsWithTheBox) {
  const double half = std::sqrt(0.5);
  const at::Tensor boxes =
      at::tensor({1.0, 2.0, 3.0, 6.0, 1.2, 0.6, half, 0.0, 0.0, half}, at::kDouble).view({1, 10});
  const at::Tensor grid = roi_grid_points(boxes, 6);
  ASSERT_EQ(grid.sizes(), (std::vector<std::int64_t>{1, 216, 3}));
  // Element (ix, iy, iz) = (5, 0, 2), turned by 90 degrees: local (2.5, -0.5, -0.05).
  const at::Tensor expected = at::tensor({1 + 0.5, 2 + 2.5, 3 - 0.05}, at::kDouble);
  expect_close(grid[0][5 * 36 + 0 * 6 + 2], expected, 1e-12);
  EXPECT_TRUE((points_in_boxes(grid[0], boxes) == 0).all().item<bool>());
  EXPECT_EQ(roi_grid_points(at::zeros({0, 10}), 6).size(0), 0);
}

TEST(PointSets, FurthestPointsOfTensors) {
  const at::Tensor chosen = furthest_points(points(100), 10);
  EXPECT_EQ(chosen[0].item<int>(), 0);
  EXPECT_EQ(std::get<0>(at::_unique(chosen)).numel(), 10);
  EXPECT_THROW(furthest_points(at::zeros({4, 2}), 1), InvalidArgument);
}

/// The definition: gather, concatenate, run every layer on every neighbour, take the maximum.
at::Tensor naive_abstraction(SetAbstraction& module, const SetAbstraction::Input& input,
                             const std::vector<AbstractionScale>& scales) {
  std::vector<at::Tensor> results;
  for (std::size_t s = 0; s < scales.size(); ++s) {
    const at::Tensor index = ball_query(input.points, input.centres,
                                        {.radius = scales[s].radius, .samples = scales[s].samples});
    at::Tensor rows = at::cat({group(input.points, index) - input.centres.unsqueeze(1),
                               group(input.features, index)},
                              2) *
                      (index >= 0).unsqueeze(-1);
    const auto parameters = module.named_parameters();
    const auto buffers = module.named_buffers();
    for (std::size_t layer = 0; layer < scales[s].widths.size(); ++layer) {
      const std::string at = "mlps." + std::to_string(s) + ".";
      const std::string norm = at + std::to_string(3 * layer + 1) + ".";
      rows = rows.matmul(parameters[at + std::to_string(3 * layer) + ".weight"].flatten(1).t());
      rows = ((rows - buffers[norm + "running_mean"]) /
                  (buffers[norm + "running_var"] + 1e-5).sqrt() * parameters[norm + "weight"] +
              parameters[norm + "bias"])
                 .relu();
    }
    results.push_back(rows.amax(1));
  }
  return at::cat(results, 1);
}

TEST(SetAbstraction, EqualsItsDefinitionFoldedAndNot) {
  const std::vector<AbstractionScale> scales = {
      {.radius = 0.5f, .samples = 8, .widths = {16, 20}},
      {.radius = 1.2f, .samples = 16, .widths = {7, 9, 5}},
      {.radius = 0.3f, .samples = 4, .widths = {6}}};
  SetAbstraction module(5, scales);
  randomize(module);
  module.eval();
  const at::Tensor from = points(400);
  const at::Tensor around = at::cat({points(60), at::ones({3, 3}) * 100});
  const SetAbstraction::Input input{
      .points = from, .features = at::randn({400, 5}), .centres = around};
  const at::Tensor expected = naive_abstraction(module, input, scales).detach();
  EXPECT_EQ(module.out_channels(), 31);
  expect_close(module.forward(input).detach(), expected);
  const at::NoGradGuard no_gradient;
  expect_close(module.forward(input), expected);
}

TEST(SetAbstraction, GradientsReachFeaturesAndParameters) {
  SetAbstraction module(3, {{.radius = 1.0f, .samples = 6, .widths = {5, 4}}});
  module.to(at::kDouble);
  const at::Tensor from = points(60), around = points(15);
  expect_gradients(
      {at::randn({60, 3}, at::kDouble)},
      [&](const auto& in) {
        return module.forward({.points = from, .features = in[0], .centres = around});
      },
      1e-4);
  module.forward({.points = from, .features = at::randn({60, 3}, at::kDouble), .centres = around})
      .sum()
      .backward();
  for (const auto& item : module.named_parameters()) {
    EXPECT_TRUE(item.value().grad().defined()) << item.key();
  }
}

TEST(SetAbstraction, NamesAreThoseOfPublishedCheckpoints) {
  const SetAbstraction module(1, {{}, {}});
  const auto all = names(module);
  EXPECT_TRUE(all.contains("mlps.0.0.weight"));
  EXPECT_TRUE(all.contains("mlps.1.3.weight"));
  EXPECT_TRUE(all.contains("mlps.1.4.running_var"));
  EXPECT_EQ(module.named_parameters()["mlps.0.0.weight"].sizes(),
            (std::vector<std::int64_t>{16, 4, 1, 1}));
  EXPECT_THROW(SetAbstraction(1, {}), InvalidArgument);
}

}  // namespace
