#include <ATen/TensorOperators.h>
#include <ATen/ops/allclose.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/full.h>
#include <ATen/ops/log_softmax.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <numbers>

#include "arbox/base/error.h"
#include "arbox/examples/toy_posterior/toy.h"
#include "arbox/geometry/overlap.h"
#include "arbox/heads/discrete_distribution.h"
#include "arbox/heads/fit_ranges.h"
#include "arbox/heads/four_point_head.h"
#include "arbox/heads/gaussian_distribution.h"
#include "arbox/heads/gaussian_head.h"
#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/point_distribution.h"
#include "arbox/heads/quartile_codec.h"
#include "arbox/heads/yaw_codecs.h"
#include "heads/random_input.h"

namespace {

using namespace arbox;
using namespace arbox::heads;
using examples::toy_input;

const examples::ToyCodec& toy_codec() {
  static const examples::ToyCodec codec;
  return codec;
}

at::Tensor random_log_probability(std::int64_t count, std::int64_t bins, std::uint64_t seed) {
  return at::log_softmax(2 * arbox::testing::normal_rows(count, bins, seed), -1);
}

DiscreteDistribution toy_discrete(std::int64_t count) {
  return {{random_log_probability(count, examples::kLengths, 1),
           random_log_probability(count, examples::kPositions, 2),
           random_log_probability(count, examples::kHeadings, 3)},
          CircularEnds::kMerged,
          std::make_shared<examples::ToyCodec>(),
          toy_input(count).references};
}

TEST(DiscreteDistribution, ModeEqualsExhaustiveSearch) {
  const DiscreteDistribution distribution = toy_discrete(2);
  const Draws best = distribution.mode({.beam_width = 20});
  const auto a = random_log_probability(2, examples::kLengths, 1);
  const auto b = random_log_probability(2, examples::kPositions, 2);
  const auto c = random_log_probability(2, examples::kHeadings, 3);
  const at::Tensor all =
      (a.view({2, -1, 1, 1}) + b.view({2, 1, -1, 1}) + c.view({2, 1, 1, -1})).flatten(1);
  double log_cell = 0;
  for (const Component& one : toy_codec().components()) log_cell += std::log(one.step());
  EXPECT_TRUE(at::allclose(best.log_density, std::get<0>(all.topk(20, 1)) - log_cell, 1e-5, 1e-5));
  EXPECT_TRUE(at::allclose(distribution.log_density(best.boxes.select(1, 7)),
                           best.log_density.select(1, 7), 1e-5, 1e-5));
}

TEST(DiscreteDistribution, SmoothedModeIsWhereMostProbabilityLies) {
  at::Tensor lengths = at::full({1, examples::kLengths}, 1e-6);
  lengths[0][0] = 0.2;  // the highest bin stands alone
  for (int bin = 4; bin < 9; ++bin) lengths[0][bin] = 0.16;
  const DiscreteDistribution distribution(
      {lengths.log(), random_log_probability(1, examples::kPositions, 2),
       random_log_probability(1, examples::kHeadings, 3)},
      CircularEnds::kMerged, std::make_shared<examples::ToyCodec>(), toy_input(1).references);
  const auto length_bin = [&](double smoothing) {
    const Draws best = distribution.mode({.beam_width = 8, .smoothing = smoothing});
    return quantize(best.components, toy_codec().components())[0][0][0].item<std::int64_t>();
  };
  EXPECT_EQ(length_bin(0.0), 0);
  EXPECT_EQ(length_bin(1.5), 6);
  for (const double bad : {-1.0, 1001.0, std::nan("")}) {
    EXPECT_THROW(distribution.mode({.smoothing = bad}), InvalidArgument) << bad;
  }
}

TEST(DiscreteDistribution, DrawsHaveTheProbabilitiesAndTheMean) {
  const DiscreteDistribution distribution = toy_discrete(1);
  const Draws draws = distribution.sample(20000, {3, at::arange(1, at::kLong)}, 1.0);
  const auto components = toy_codec().components();
  const at::Tensor bins = quantize(draws.components, components);
  for (std::int64_t i = 0; i < 3; ++i) {
    const at::Tensor expected = (i == 0   ? random_log_probability(1, examples::kLengths, 1)
                                 : i == 1 ? random_log_probability(1, examples::kPositions, 2)
                                          : random_log_probability(1, examples::kHeadings, 3))
                                    .exp()[0];
    const at::Tensor counted =
        bins.select(2, i)[0].bincount({}, expected.size(0)).to(at::kFloat) / 20000;
    EXPECT_LT((counted - expected).abs().sum().item<double>() / 2, 0.02) << "component " << i;
  }
  const at::Tensor mean = internal::mean_of_values(draws.components, components);
  const at::Tensor expected = toy_codec().encode(distribution.mean(), {});
  EXPECT_LT((mean - expected).abs().max().item<double>(), 0.1);
}

TEST(ExpectedValue, IsCircularWhereTheComponentIs) {
  const Component angle{"yaw", 0.0, std::numbers::pi, 16, true};
  at::Tensor probability = at::zeros({15});
  probability[1] = 0.5;   // a step above 0
  probability[14] = 0.5;  // a step below pi, which is 0
  const double mean = internal::expected_value(probability, angle).item<double>();
  EXPECT_NEAR(std::min(mean, std::numbers::pi - mean), 0.0, 1e-5);
  EXPECT_NEAR(internal::expected_value(probability, {"x", 0.0, 15.0, 16, false}).item<double>(),
              7.5, 1e-5);
}

TEST(GaussianDistribution, DensityIntegratesToOneAlsoAroundACircle) {
  const std::vector<Component> components = {{"x", -1.0, 1.0, 16, false},
                                             {"yaw", 0.0, std::numbers::pi, 16, true}};
  constexpr std::int64_t kSteps = 4000;
  for (const double deviation : {0.05, 0.7, 3.0}) {
    const at::Tensor x = at::arange(kSteps, at::kDouble) * (40.0 / kSteps) - 20.0;
    const at::Tensor yaw = at::arange(kSteps, at::kDouble) * (std::numbers::pi / kSteps);
    const at::Tensor values = at::stack({x, yaw}, -1).unsqueeze(0);
    const at::Tensor density =
        gaussian_log_density(values, at::full({1, 2}, 0.1, at::kDouble),
                             at::full({1, 2}, deviation, at::kDouble), components)
            .exp()[0];
    EXPECT_NEAR(density.select(-1, 0).sum().item<double>() * 40.0 / kSteps, 1.0, 2e-3);
    EXPECT_NEAR(density.select(-1, 1).sum().item<double>() * std::numbers::pi / kSteps, 1.0, 2e-3);
  }
}

TEST(GaussianDistribution, DrawsHaveMomentsAndPositiveSizes) {
  const HeadContext context = {
      .features = 4, .condition = 0, .codec = std::make_shared<ScaledCodec>()};
  const auto objects = arbox::testing::random_objects(context, 2, 6);
  const at::Tensor mean = at::full({2, 7}, 0.4f), deviation = at::full({2, 7}, 0.3f);
  const GaussianDistribution distribution(mean, deviation, context.codec, objects.input.references);
  const Draws draws = distribution.sample(4000, {3, at::arange(2, at::kLong)}, 1.0);
  EXPECT_GT(draws.boxes.slice(2, 3, 6).min().item<double>(), 0.0);
  EXPECT_LT(draws.components.slice(2, 3, 6).mean(1).sub(0.4).abs().max().item<double>(), 0.02);
  EXPECT_LT(draws.components.slice(2, 3, 6).std(1).sub(0.3).abs().max().item<double>(), 0.02);
  EXPECT_GE(draws.components.select(2, 6).min().item<double>(), 0.0);
  EXPECT_LT(draws.components.select(2, 6).max().item<double>(), std::numbers::pi);
  const Draws cold = distribution.sample(4000, {3, at::arange(2, at::kLong)}, 0.25);
  EXPECT_LT(cold.components.slice(2, 3, 6).std(1).sub(0.15).abs().max().item<double>(), 0.01);
}

TEST(GaussianDistribution, KnownSizesAreKeptAndDoNotCount) {
  const HeadContext context = {
      .features = 4, .condition = 0, .codec = std::make_shared<ResidualCodec>()};
  const auto objects = arbox::testing::random_objects(context, 3, 6);
  const at::Tensor mean = at::zeros({3, 7}), deviation = at::full({3, 7}, 0.1f);
  const GaussianDistribution distribution(mean, deviation, context.codec, objects.input.references);
  const at::Tensor sizes = objects.boxes.slice(1, 3, 6);
  const auto given = distribution.given_sizes(sizes);
  const Draws best = given->mode({.beam_width = 4});
  EXPECT_TRUE(at::allclose(best.boxes.select(1, 0).slice(1, 3, 6), sizes));
  const double peak = -4 * std::log(0.1 * std::sqrt(2 * std::numbers::pi));
  EXPECT_NEAR(best.log_density[0][0].item<double>(), peak, 1e-3);
  EXPECT_TRUE(given->log_density(distribution.mode({.beam_width = 1}).boxes.select(1, 0))
                  .isinf()
                  .all()
                  .item<bool>());
}

TEST(GaussianDistribution, DensityOfSizesIsThatOfTheirComponents) {
  const HeadContext context = {
      .features = 4, .condition = 0, .codec = std::make_shared<ScaledCodec>()};
  const auto objects = arbox::testing::random_objects(context, 3, 6);
  const GaussianDistribution distribution(at::full({3, 7}, 0.4f), at::full({3, 7}, 0.1f),
                                          context.codec, objects.input.references);
  const at::Tensor sizes = distribution.mean().slice(1, 3, 6);
  const double peak = -3 * std::log(0.1 * std::sqrt(2 * std::numbers::pi));
  EXPECT_LT((distribution.log_size_density(sizes) - peak).abs().max().item<double>(), 1e-3);
  // One deviation off in one component.
  at::Tensor longer = sizes.clone();
  longer.select(1, 0) += 0.1 * objects.input.references.size.select(1, 0);
  EXPECT_LT((distribution.log_size_density(longer) - (peak - 0.5)).abs().max().item<double>(),
            1e-3);
  EXPECT_LT((distribution.given_sizes(sizes)->log_size_density(longer) - (peak - 0.5))
                .abs()
                .max()
                .item<double>(),
            1e-3);
}

TEST(DiscreteDistribution, DensityOfSizesIsTheirBinsMassOverTheirWidth) {
  YawCodecOptions options = ScaledCodec::defaults();
  options.bins = 9;
  options.size_high = 8;
  const auto codec = std::make_shared<ScaledCodec>(options);
  const HeadContext context = {.features = 4, .condition = 0, .codec = codec};
  const auto objects = arbox::testing::random_objects(context, 2, 6);
  std::vector<at::Tensor> columns;
  for (int i = 0; i < 7; ++i) {
    columns.push_back(random_log_probability(2, i == 6 ? 8 : 9, 20 + static_cast<unsigned>(i)));
  }
  const DiscreteDistribution distribution(columns, CircularEnds::kMerged, codec,
                                          objects.input.references);
  const at::Tensor scale = objects.input.references.size.slice(1, 0, 1);
  const at::Tensor sizes = scale * at::tensor({2.0, 5.0, 7.4});
  at::Tensor expected = columns[0].select(1, 2) + columns[1].select(1, 5) + columns[2].select(1, 7);
  EXPECT_TRUE(at::allclose(distribution.log_size_density(sizes), expected, 1e-5, 1e-5));
  EXPECT_TRUE(distribution.log_size_density(sizes + 9 * scale).isinf().all().item<bool>());
}

TEST(PointDistribution, RepeatsItsBoxAndHasNoLikelihood) {
  const HeadContext context = {
      .features = 4, .condition = 0, .codec = std::make_shared<ScaledCodec>()};
  const auto objects = arbox::testing::random_objects(context, 3, 6);
  const PointDistribution distribution(-at::full({3, 7}, 0.2f), context.codec,
                                       objects.input.references);
  const Draws draws = distribution.sample(5, {1, at::arange(3, at::kLong)}, 1.0);
  EXPECT_TRUE(draws.boxes.select(1, 4).equal(distribution.mean()));
  EXPECT_GT(draws.boxes.slice(2, 3, 6).min().item<double>(), 0.0);  // negative sizes were asked for
  EXPECT_EQ(distribution.measure(), Measure::kNone);
  EXPECT_THROW(distribution.log_density(objects.boxes), NotAvailable);
  EXPECT_THROW(entropy(distribution, 4, {1, at::arange(3, at::kLong)}), NotAvailable);
  EXPECT_THROW(PointDistribution(objects.boxes).given_sizes(objects.boxes.slice(1, 3, 6)),
               NotAvailable);
}

TEST(Entropy, OfUniformBinsIsTheLogOfTheVolume) {
  const auto uniform = [](std::int64_t bins) {
    return at::full({2, bins}, -std::log(static_cast<double>(bins)));
  };
  const DiscreteDistribution distribution(
      {uniform(examples::kLengths), uniform(examples::kPositions), uniform(examples::kHeadings)},
      CircularEnds::kMerged, std::make_shared<examples::ToyCodec>(), toy_input(2).references);
  double expected = std::log(16.0 * 16.0 * 15.0);
  for (const Component& one : toy_codec().components()) expected += std::log(one.step());
  EXPECT_NEAR(entropy(distribution, 8, {1, at::arange(2, at::kLong)})[1].item<double>(), expected,
              1e-4);
}

TEST(FourPoint, EveryAssignmentIsTheSameBoxAndNoMirrorIs) {
  const HeadContext context = {
      .features = 4, .condition = 0, .codec = std::make_shared<QuartileCodec>()};
  const auto objects = arbox::testing::random_objects(context, 20, 6, at::kDouble);
  const References& references = objects.input.references;
  const at::Tensor corners = corner_assignments(objects.boxes, references);
  ASSERT_EQ(corners.sizes(), (std::vector<std::int64_t>{20, 24, 4, 3}));
  const auto truth = to_boxes(objects.boxes);
  for (std::int64_t k = 0; k < 24; ++k) {
    const auto back = to_boxes(box_of_corners(corners.select(1, k), references));
    for (std::size_t n = 0; n < truth.size(); ++n) {
      EXPECT_GT(geometry::overlap(back[n], truth[n]), 1 - 1e-4);
    }
    for (std::int64_t j = 0; j < k; ++j) {
      EXPECT_GT(
          (corners.select(1, k) - corners.select(1, j)).abs().amax({1, 2}).min().item<double>(),
          1e-3);
    }
    const at::Tensor edge = corners.select(1, k).slice(1, 1) - corners.select(1, k).slice(1, 0, 1);
    EXPECT_GT(edge.det().min().item<double>(), 0.0);
  }
}

TEST(FourPoint, AnUntrainedHeadStartsAtTheReference) {
  HeadContext context = {.features = 4, .condition = 0, .codec = std::make_shared<QuartileCodec>()};
  FourPointHead head({}, context);
  for (at::Tensor& parameter : head.parameters()) parameter.detach().zero_();
  const auto objects = arbox::testing::random_objects(context, 4, 2);
  const at::Tensor boxes = head.forward(objects.input)->mean();
  EXPECT_TRUE(at::allclose(boxes.slice(1, 0, 3), objects.input.references.origin, 1e-4, 1e-4));
  EXPECT_TRUE(at::allclose(boxes.slice(1, 3, 6), objects.input.references.size, 1e-4, 1e-4));
}

TEST(FitRanges, ReportsIouAndOverflow) {
  const std::vector<geometry::Box> regions(100, geometry::make_yaw_box({1, 2, 3}, {4, 2, 1}, 0.5));
  std::vector<geometry::Box> boxes = regions;
  boxes[7].size.x() *= 10;  // log 10 is out of [-0.5, 0.5]
  const at::Tensor rows = to_tensor(regions, at::kDouble);
  const References references = {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
  const RangeFit given = evaluate_ranges(boxes, references, {});
  EXPECT_NEAR(given.overflow, 1.0 / 700, 1e-12);
  EXPECT_GT(given.mean_iou, 0.98);   // every value is half a step off
  EXPECT_LT(given.mean_iou, 0.992);  // the long box keeps a sixth of itself
  EXPECT_FALSE(given.reached);
  const RangeFit fitted = fit_ranges(boxes, references, {});
  EXPECT_TRUE(fitted.reached);
  EXPECT_GT(*fitted.codec.size_high, std::log(10.0));
  EXPECT_EQ(fitted.overflow, 0.0);
  EXPECT_THROW(fit_ranges({}, references, {}), InvalidArgument);
  EXPECT_THROW(simulated_references(boxes, "polar", 1, 0), InvalidArgument);
  const References again = simulated_references(boxes, "residual", 2, 3);
  EXPECT_EQ(again.count(), 200);
  EXPECT_TRUE(again.origin.equal(simulated_references(boxes, "residual", 2, 3).origin));
}

TEST(Heads, AHugeBatchAndNoObjectsAreOrdinary) {
  GaussianOptions options;
  options.hidden = {8};
  const HeadContext context = {
      .features = 4, .condition = 0, .codec = std::make_shared<ResidualCodec>()};
  GaussianHead head(options, context);
  for (const std::int64_t count : {std::int64_t{0}, std::int64_t{50000}}) {
    const auto objects = arbox::testing::random_objects(context, count, 2);
    EXPECT_EQ(head.forward(objects.input)->mode({.beam_width = 1}).boxes.size(0), count);
    EXPECT_EQ(head.loss(objects.input, objects.boxes).per_object.size(0), count);
  }
}

}  // namespace
