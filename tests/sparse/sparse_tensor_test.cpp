#include "arbox/sparse/sparse_tensor.h"

#include <ATen/TensorIndexing.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/ivalue.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/conv3d.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/max_pool3d.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/rand.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <cmath>

#include "arbox/base/error.h"
#include "arbox/sparse/convolution.h"
#include "arbox/sparse/pooling.h"
#include "arbox/sparse/voxel_sets.h"
#include "arbox/sparse/voxel_tensor.h"
#include "sparse/expect_close.h"
#include "sparse/gradient_check.h"
#include "sparse/made_voxels.h"

namespace {

using namespace arbox;
using namespace arbox::sparse;

constexpr std::int32_t kSide = 9;

SparseTensor made(std::int64_t channels, at::ScalarType type = at::kFloat, bool grid = true,
                  std::size_t voxels = 120, std::int32_t step = 1) {
  const auto coordinates = random_voxels(3, voxels, 2, grid ? 0 : -4, kSide, step);
  const Lattice lattice =
      grid ? Lattice{.grid = Triple{kSide, kSide, kSide}} : Lattice{.stride = {step, step, step}};
  return SparseTensor(to_tensor(coordinates), at::randn({std::int64_t(voxels), channels}, type),
                      lattice, 2);
}

/// Dense weights (out, in, Z, Y, X) of element weights.
at::Tensor dense_weight(const at::Tensor& weight, const Kernel& kernel) {
  return weight
      .view({kernel.size[2], kernel.size[1], kernel.size[0], weight.size(1), weight.size(2)})
      .permute({4, 3, 0, 1, 2})
      .contiguous();
}

std::vector<std::int64_t> zyx(const Triple& triple) { return {triple[2], triple[1], triple[0]}; }

struct DenseCase {
  const char* name;
  Kernel kernel;
  std::int64_t in_channels, out_channels;
  std::size_t voxels = 120;
};

class AgainstDense : public ::testing::TestWithParam<DenseCase> {};

TEST_P(AgainstDense, ConvolutionEqualsConv3d) {
  const auto& [name, kernel, in_channels, out_channels, voxels] = GetParam();
  const SparseTensor input = made(in_channels, at::kFloat, true, voxels);
  const at::Tensor weight = at::randn({kernel.elements(), in_channels, out_channels});
  const SparseTensor output = convolution(input, weight, kernel);
  Triple padding = kernel.padding;
  for (int axis = 0; axis < 3 && kernel.submanifold; ++axis) {
    padding[axis] = kernel.size[axis] / 2 * kernel.dilation[axis];
  }
  const at::Tensor dense = at::conv3d(to_dense(input).to(at::kDouble).contiguous(),
                                      dense_weight(weight, kernel).to(at::kDouble), {},
                                      zyx(kernel.stride), zyx(padding), zyx(kernel.dilation));
  const at::Tensor places = output.coordinates().to(at::kLong);
  const at::Tensor expected = dense.permute({0, 2, 3, 4, 1})
                                  .index({places.select(1, 0), places.select(1, 3),
                                          places.select(1, 2), places.select(1, 1)});
  expect_close(output.features().to(at::kDouble), expected);
  if (!kernel.submanifold) expect_close(to_dense(output).to(at::kDouble), dense);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, AgainstDense,
    ::testing::Values(
        DenseCase{"submanifold", {.submanifold = true}, 4, 16},
        DenseCase{"submanifold_dilated", {.dilation = {1, 2, 3}, .submanifold = true}, 16, 16},
        DenseCase{"submanifold_five", {.size = {5, 3, 1}, .submanifold = true}, 7, 33},
        DenseCase{"down", {.stride = {2, 2, 2}, .padding = {1, 1, 1}}, 16, 32},
        DenseCase{"down_flat", {.stride = {2, 2, 2}, .padding = {1, 1, 0}}, 64, 64},
        DenseCase{"height", {.size = {1, 1, 3}, .stride = {1, 1, 2}}, 64, 128},
        DenseCase{"even", {.size = {2, 2, 2}, .stride = {2, 2, 2}}, 1, 256},
        DenseCase{
            "dilated", {.size = {3, 2, 3}, .dilation = {2, 1, 1}, .padding = {2, 0, 1}}, 256, 1},
        DenseCase{"wide", {.submanifold = true}, 256, 256, 30},
        DenseCase{"one", {.stride = {2, 2, 2}, .padding = {1, 1, 1}}, 16, 16, 1},
        DenseCase{"none", {.submanifold = true}, 16, 16, 0},
        DenseCase{"none_down", {.stride = {2, 2, 2}, .padding = {1, 1, 1}}, 16, 16, 0}),
    [](const auto& test) { return test.param.name; });

TEST(Convolution, GradientsEqualCentralDifferences) {
  const SparseTensor input = made(3, at::kDouble, false, 40);
  const at::Tensor coordinates = input.coordinates();
  const at::Tensor weight = at::randn({27, 3, 2}, at::kDouble), bias = at::randn({2}, at::kDouble);
  for (const std::int32_t stride : {1, 2}) {
    expect_gradients({input.features(), weight, bias}, [&](const auto& in) {
      return convolution(input.with_features(in[0]), in[1], {.stride = {stride, stride, stride}},
                         in[2])
          .features();
    });
  }
}

TEST(Convolution, TransposedAndGenerativeGradientsEqualCentralDifferences) {
  const SparseTensor fine = made(3, at::kDouble, false, 40, 2);
  const Kernel kernel{.size = {2, 2, 2}, .stride = {2, 2, 2}};
  const at::Tensor weight = at::randn({8, 3, 2}, at::kDouble);
  const SparseTensor coarse = convolution(fine, at::randn({8, 3, 3}, at::kDouble), kernel);
  expect_gradients({coarse.features(), weight}, [&](const auto& in) {
    return transposed_convolution(coarse.with_features(in[0]), fine, in[1], kernel).features();
  });
  expect_gradients({fine.features(), weight}, [&](const auto& in) {
    return generative_convolution(fine.with_features(in[0]), in[1], kernel).features();
  });
}

TEST(Convolution, FloatKernelsGiveTheGradientsOfThePlainPath) {
  const SparseTensor input = made(20, at::kFloat, false);
  const at::Tensor weight = at::randn({27, 20, 35}), bias = at::randn({1, 35});
  const Kernel kernel{.stride = {2, 2, 2}};
  const auto gradients = [&](at::ScalarType type) {
    const auto leaf = [type](const at::Tensor& t) {
      return t.to(type, false, true).set_requires_grad(true);
    };
    const std::vector<at::Tensor> in = {leaf(input.features()), leaf(weight), leaf(bias)};
    const at::Tensor out = convolution(input.with_features(in[0]), in[1], kernel, in[2]).features();
    const at::Tensor seed = at::arange(out.numel(), at::kDouble).sin().view(out.sizes());
    auto result = torch::autograd::grad({out}, in, {seed.to(type)});
    result.push_back(out.detach());
    return result;
  };
  const auto own = gradients(at::kFloat), plain = gradients(at::kDouble);
  for (std::size_t i = 0; i < own.size(); ++i) expect_close(own[i].to(at::kDouble), plain[i]);
}

TEST(Convolution, TransposedIsTheAdjointOfTheForwardOne) {
  const SparseTensor fine = made(5, at::kDouble, false);
  const Kernel kernel{.stride = {2, 2, 2}};
  const at::Tensor weight = at::randn({27, 5, 4}, at::kDouble);
  const SparseTensor coarse = convolution(fine, weight, kernel);
  const SparseTensor back =
      transposed_convolution(coarse, fine, weight.transpose(1, 2).contiguous(), kernel);
  EXPECT_NEAR((back.features() * fine.features()).sum().item<double>(),
              coarse.features().square().sum().item<double>(), 1e-8);
}

TEST(Convolution, ShortcutReadsOnlyTheExactCoordinate) {
  const at::Tensor coordinates = at::tensor({0, 0, 0, 0, 0, 3, 2, 2}, at::kInt).view({2, 4});
  const SparseTensor input(coordinates, at::ones({2, 1}));
  const SparseTensor output =
      convolution(input, at::ones({1, 1, 1}), {.size = {1, 1, 1}, .stride = {2, 2, 2}});
  ASSERT_EQ(output.size(), 2);
  EXPECT_EQ(output.features()[0].item<float>(), 1);
  EXPECT_EQ(output.features()[1].item<float>(), 0);
  EXPECT_EQ(output.lattice().stride, (Triple{2, 2, 2}));
}

TEST(Convolution, FusedEpilogueEqualsItsParts) {
  for (const auto type : {at::kFloat, at::kDouble}) {
    const SparseTensor input = made(6, type, false);
    const at::Tensor weight = at::randn({27, 6, 10}, type);
    const Connection connection = input.manager().convolution(input.set(), {});
    const FusedEpilogue epilogue{.scale = at::randn({10}, type),
                                 .shift = at::randn({10}, type),
                                 .residual = at::randn({input.size(), 10}, type),
                                 .relu = true};
    const at::Tensor plain = convolve(connection, input.features(), weight);
    expect_close(convolve_fused(connection, input.features(), weight, epilogue),
                 (plain * epilogue.scale + epilogue.shift + epilogue.residual).relu());
  }
}

TEST(Convolution, RefusesWhatDoesNotFit) {
  const SparseTensor input = made(4);
  EXPECT_THROW(convolution(input, at::randn({27, 5, 2}), {.submanifold = true}), InvalidArgument);
  EXPECT_THROW(convolution(input, at::randn({8, 4, 2}), {.submanifold = true}), InvalidArgument);
  EXPECT_THROW(convolution(input, at::randn({27, 4, 2}, at::kDouble), {.submanifold = true}),
               InvalidArgument);
  EXPECT_THROW(convolution(input, at::randn({27, 4, 2}), {.submanifold = true}, at::randn({3})),
               InvalidArgument);
  EXPECT_THROW(generative_convolution(input, at::randn({27, 4, 2}), {}), InvalidArgument);
}

TEST(SparseTensor, RefusesWhatIsNoTensor) {
  const at::Tensor coordinates = at::zeros({1, 4}, at::kInt);
  EXPECT_THROW(SparseTensor(at::zeros({1, 3}, at::kInt), at::ones({1, 2})), InvalidArgument);
  EXPECT_THROW(SparseTensor(at::zeros({1, 4}), at::ones({1, 2})), InvalidArgument);
  EXPECT_THROW(SparseTensor(coordinates, at::ones({2, 2})), InvalidArgument);
  EXPECT_THROW(SparseTensor(coordinates, at::ones({1, 2}, at::kInt)), InvalidArgument);
  EXPECT_THROW(SparseTensor(coordinates, at::Tensor()), InvalidArgument);
  EXPECT_THROW(SparseTensor(at::zeros({2, 4}, at::kInt), at::ones({2, 2})), InvalidArgument);
  EXPECT_THROW(SparseTensor(at::ones({1, 4}, at::kInt), at::ones({1, 2}), {}, 1), InvalidArgument);
  EXPECT_THROW(
      SparseTensor(at::ones({1, 4}, at::kLong) * (std::int64_t{1} << 40), at::ones({1, 2})),
      InvalidArgument);
}

TEST(Pooling, EqualsDensePoolingWhereInputsArePositive) {
  const SparseTensor signed_input = made(5);
  const SparseTensor input = signed_input.with_features(signed_input.features().abs() + 0.1);
  const Kernel kernel{.stride = {2, 2, 2}, .padding = {1, 1, 1}};
  expect_close(to_dense(max_pool(input, kernel)),
               at::max_pool3d(to_dense(input).contiguous(), {3, 3, 3}, {2, 2, 2}, {1, 1, 1}));
  const at::Tensor ones = at::ones({27, 1, 1});
  const SparseTensor counts =
      convolution(input.with_features(at::ones({input.size(), 1})), ones, kernel);
  const SparseTensor sums =
      convolution(input.with_features(input.features().slice(1, 0, 1).contiguous()), ones, kernel);
  expect_close(average_pool(input, kernel).features().slice(1, 0, 1),
               sums.features() / counts.features());
}

TEST(Pooling, NegativeMaximaAreKept) {
  const SparseTensor input(at::tensor({0, -1, 0, 0}, at::kInt).view({1, 4}), at::ones({1, 2}) * -3);
  const SparseTensor output = max_pool(input, {.size = {2, 2, 2}, .stride = {2, 2, 2}});
  EXPECT_EQ(output.coordinates()[0][1].item<int>(), -2);
  EXPECT_EQ(output.features()[0][0].item<float>(), -3);
}

TEST(Pooling, GradientsEqualCentralDifferences) {
  const SparseTensor input = made(3, at::kDouble, false);
  const Kernel kernel{.stride = {2, 2, 2}};
  expect_gradients({input.features()}, [&](const auto& in) {
    return max_pool(input.with_features(in[0]), kernel).features();
  });
  expect_gradients({input.features()}, [&](const auto& in) {
    return average_pool(input.with_features(in[0]), kernel).features();
  });
}

TEST(Prune, KeepsRowsInTheirOrder) {
  const SparseTensor input = made(2, at::kDouble, false);
  const at::Tensor keep = input.features().select(1, 0) > 0;
  const SparseTensor kept = prune(input, keep);
  expect_close(kept.features(), input.features().index({keep}));
  EXPECT_TRUE(kept.coordinates().equal(input.coordinates().index({keep})));
  EXPECT_EQ(prune(input, at::zeros({input.size()}, at::kBool)).size(), 0);
  EXPECT_THROW(prune(input, at::zeros({3}, at::kBool)), InvalidArgument);
  // A pruned tensor can be convolved.
  EXPECT_EQ(convolution(kept, at::randn({27, 2, 3}, at::kDouble), {}).size(), kept.size());
}

TEST(Prune, HighestInEachSceneWithTiesAndNaN) {
  const at::Tensor coordinates =
      at::tensor({0, 5, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0}, at::kInt)
          .view({5, 4});
  const SparseTensor input(coordinates, at::ones({5, 1}));
  const at::Tensor scores = at::tensor({1.0, 0.5, NAN, 1.0, 2.0});
  EXPECT_TRUE(
      highest_in_each_scene(input, scores, 2).equal(at::tensor({1, 1, 0, 0, 1}).to(at::kBool)));
  EXPECT_EQ(highest_in_each_scene(input, scores, 9).sum().item<int>(), 5);
  EXPECT_EQ(highest_in_each_scene(input, scores, 0).sum().item<int>(), 0);
  EXPECT_THROW(highest_in_each_scene(input, scores, -1), InvalidArgument);
}

TEST(Add, EqualsDenseAdditionAndItsGradients) {
  const SparseTensor a = made(3, at::kDouble, true, 150);
  const SparseTensor b(to_tensor(random_voxels(9, 90, 2, 0, kSide)),
                       at::randn({90, 3}, at::kDouble), a.lattice(), 2);
  expect_close(to_dense(add(a, b)), to_dense(a) + to_dense(b), 1e-12);
  expect_gradients({a.features(), b.features()}, [&](const auto& in) {
    return add(a.with_features(in[0]), b.with_features(in[1])).features();
  });
  expect_close(add(a, a).features(), a.features() * 2, 1e-12);
  EXPECT_THROW(add(a, made(4, at::kDouble)), InvalidArgument);
  EXPECT_THROW(add(a, made(3, at::kDouble, false)), InvalidArgument);
}

TEST(Interpolate, EqualsTheTrilinearSum) {
  const SparseTensor input = made(3, at::kDouble, false, 300, 4);
  const at::Tensor dense = to_dense(input, {.low = {-40, -40, -40}, .cells = {24, 24, 24}});
  const at::Tensor places =
      at::cat({at::zeros({200, 1}, at::kDouble), at::rand({200, 3}, at::kDouble) * 40 - 20}, 1);
  const at::Tensor got = interpolate(input, places);
  for (std::int64_t i = 0; i < places.size(0); ++i) {
    at::Tensor expected = at::zeros({3}, at::kDouble);
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::int64_t cell[3];
      for (int axis = 0; axis < 3; ++axis) {
        const double t = (places[i][axis + 1].item<double>() + 40) / 4;
        const bool high = (corner >> axis & 1) != 0;
        cell[axis] = static_cast<std::int64_t>(std::floor(t)) + high;
        weight *= high ? t - std::floor(t) : 1 - t + std::floor(t);
      }
      expected +=
          weight * dense.select(0, 0).select(1, cell[2]).select(1, cell[1]).select(1, cell[0]);
    }
    expect_close(got[i], expected, 1e-9);
  }
  expect_gradients({input.features()},
                   [&](const auto& in) { return interpolate(input.with_features(in[0]), places); });
}

TEST(Interpolate, IsALookupAtVoxelsAndZeroFarAway) {
  const SparseTensor input = made(2, at::kFloat, false, 100, 2);
  expect_close(interpolate(input, input.coordinates()), input.features(), 0);
  const at::Tensor far =
      at::tensor({0.0, 1e30, 0.0, 0.0, 7.0, 0.0, 0.0, 0.0, 0.0, NAN, 0.0, 0.0}).view({3, 4});
  EXPECT_EQ(interpolate(input, far).abs().sum().item<float>(), 0);
  EXPECT_EQ(interpolate(input, at::zeros({0, 4})).size(0), 0);
}

TEST(Dense, RoundTripsAndItsGradients) {
  const SparseTensor input = made(3, at::kDouble);
  const SparseTensor back = from_dense(to_dense(input), input.lattice());
  EXPECT_EQ(back.size(), input.size());
  expect_close(to_dense(back), to_dense(input), 1e-15);
  const SparseTensor unbounded = made(2, at::kDouble, false, 80, 2);
  const DenseRegion region{.low = {-8, -8, -8}, .cells = {9, 9, 9}};
  const SparseTensor again =
      from_dense(to_dense(unbounded, region), unbounded.lattice(), region.low);
  EXPECT_EQ(again.size(), unbounded.size());
  expect_close(interpolate(again, unbounded.coordinates()), unbounded.features(), 1e-15);
  expect_gradients({input.features()},
                   [&](const auto& in) { return to_dense(input.with_features(in[0])); });
  EXPECT_THROW(to_dense(unbounded), InvalidArgument);
  EXPECT_EQ(from_dense(at::ones({1, 1, 2, 2, 2}), {}, {0, 0, 0}, at::zeros({1, 2, 2, 2}, at::kBool))
                .size(),
            0);
}

TEST(Dense, BirdsEyeChannelsAreChannelTimesHeights) {
  const SparseTensor input = made(4);
  const at::Tensor seen = birds_eye(input), dense = to_dense(input);
  EXPECT_EQ(seen.sizes(), (std::vector<std::int64_t>{2, 4 * kSide, kSide, kSide}));
  for (std::int64_t c = 0; c < 4; ++c) {
    for (std::int64_t z = 0; z < kSide; ++z) {
      EXPECT_TRUE(seen.select(1, c * kSide + z).equal(dense.select(1, c).select(1, z)));
    }
  }
}

TEST(VoxelTensor, ScenesBecomeBatchNumbers) {
  const std::vector<float> rows = {0, 0, 0, 3, 0, 0};
  const auto view = geometry::PointCloudView::packed(rows.data(), 2);
  const Voxels scene = voxelize(view, {}, {.voxel_size = {1, 1, 1}});
  const SparseTensor tensor = to_sparse_tensor(std::vector<Voxels>{scene, {}, scene});
  EXPECT_EQ(tensor.batch_size(), 3);
  EXPECT_EQ(tensor.size(), 4);
  EXPECT_TRUE(tensor.batch_numbers().equal(at::tensor({0, 0, 2, 2}, at::kLong)));
  EXPECT_EQ(to_sparse_tensor({}).size(), 0);
}

}  // namespace
