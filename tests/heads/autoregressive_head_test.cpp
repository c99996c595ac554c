#include "arbox/heads/autoregressive_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/allclose.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/log_softmax.h>
#include <gtest/gtest.h>

#include "arbox/base/error.h"
#include "arbox/examples/toy_posterior/toy.h"
#include "arbox/heads/quartile_codec.h"
#include "arbox/heads/yaw_codecs.h"
#include "heads/random_input.h"

namespace {

using namespace arbox;
using namespace arbox::heads;

HeadContext residual_context(int bins = 32) {
  YawCodecOptions options = ResidualCodec::defaults();
  options.bins = bins;
  return {.features = 6, .condition = 4, .codec = std::make_shared<ResidualCodec>(options)};
}

AutoregressiveOptions small(CircularEnds ends = CircularEnds::kMerged) {
  AutoregressiveOptions options;
  options.hidden = {16, 24};
  options.circular_ends = ends;
  return options;
}

const AutoregressiveDistribution& autoregressive(const BoxDistribution& distribution) {
  return dynamic_cast<const AutoregressiveDistribution&>(distribution);
}

TEST(AutoregressiveHead, ParametersHaveThePublishedKeys) {
  const AutoregressiveHead head({}, residual_context(512));
  const auto names = head.named_parameters().keys();
  EXPECT_EQ(names.size(), 7u * 4 * 2);
  EXPECT_EQ(names.front(), "autoreg.0.0.weight");
  EXPECT_EQ(names.back(), "autoreg.6.6.bias");
  const auto& parameters = head.named_parameters();
  EXPECT_EQ(parameters["autoreg.3.0.weight"].sizes(), (std::vector<std::int64_t>{128, 6 + 4 + 3}));
  EXPECT_EQ(parameters["autoreg.6.6.weight"].sizes(), (std::vector<std::int64_t>{512, 512}));
}

// Published: 3,230,080 for features of 256 and a condition of 7.
TEST(AutoregressiveHead, HasThePublishedNumberOfParameters) {
  HeadContext context = residual_context(512);
  context.features = 256;
  context.condition = 7;
  std::int64_t count = 0;
  for (const auto& one : AutoregressiveHead({}, context).parameters()) count += one.numel();
  EXPECT_EQ(count, 3230080);
  count = 0;
  context = {.features = 128, .condition = 0, .codec = std::make_shared<QuartileCodec>()};
  const AutoregressiveHead estimator(AutoregressiveOptions::estimator(), context);
  for (const auto& one : estimator.parameters()) count += one.numel();
  EXPECT_EQ(count, 11085696);
}

TEST(AutoregressiveHead, TeacherForcingAndInferenceGiveTheSameProbabilities) {
  for (const CircularEnds ends : {CircularEnds::kMerged, CircularEnds::kDistinct}) {
    const HeadContext context = residual_context();
    AutoregressiveHead head(small(ends), context);
    const auto objects = arbox::testing::random_objects(context, 40, 3);
    const auto distribution = head.forward(objects.input);
    const Draws draws = distribution->sample(5, {7, at::arange(40, at::kLong)});
    const at::Tensor forced = head.log_probability(objects.input.joined(), draws.components);
    const at::Tensor inferred = autoregressive(*distribution).log_probability(draws.components);
    EXPECT_TRUE(at::allclose(forced, inferred, 1e-4, 1e-4));
    double log_cell = 0;
    for (const Component& component : context.codec->components()) {
      log_cell += std::log(component.step());
    }
    EXPECT_TRUE(at::allclose(draws.log_density + log_cell, inferred, 1e-4, 1e-4));
    const Draws best = distribution->mode({.beam_width = 4});
    EXPECT_TRUE(at::allclose(head.log_probability(objects.input.joined(), best.components),
                             best.log_density + log_cell, 1e-4, 1e-4));
  }
}

TEST(AutoregressiveHead, FactorsMakeTheJointByEnumeration) {
  const HeadContext context = examples::toy_context();
  AutoregressiveHead head(small(), context);
  const auto components = context.codec->components();
  const at::Tensor inputs = examples::toy_input(1).features;
  // The joint from the conditionals alone, by the chain rule over every prefix.
  double sum = 0, worst = 0;
  std::vector<float> values;
  std::vector<double> expected;
  const auto value = [&](std::size_t i, int bin) {
    return static_cast<float>(components[i].low + bin * components[i].step());
  };
  const auto conditional = [&](std::int64_t i, const std::vector<float>& prefix) {
    at::Tensor previous = at::zeros({1, 1, static_cast<std::int64_t>(prefix.size())});
    std::copy(prefix.begin(), prefix.end(), previous.data_ptr<float>());
    return at::log_softmax(head.conditional(i, inputs, previous), -1).detach().reshape(-1);
  };
  const at::Tensor first = conditional(0, {});
  for (int a = 0; a < examples::kLengths; ++a) {
    const at::Tensor second = conditional(1, {value(0, a)});
    for (int b = 0; b < examples::kPositions; ++b) {
      const at::Tensor third = conditional(2, {value(0, a), value(1, b)});
      ASSERT_EQ(third.numel(), examples::kHeadings);
      for (int c = 0; c < examples::kHeadings; ++c) {
        values.insert(values.end(), {value(0, a), value(1, b), value(2, c)});
        expected.push_back((first[a] + second[b] + third[c]).item<double>());
        sum += std::exp(expected.back());
      }
    }
  }
  EXPECT_NEAR(sum, 1.0, 1e-4);
  const auto count = static_cast<std::int64_t>(expected.size());
  at::Tensor rows = at::zeros({1, count, 3});
  std::copy(values.begin(), values.end(), rows.data_ptr<float>());
  const at::Tensor joint = head.log_probability(inputs, rows).detach();
  const auto distribution = head.forward(examples::toy_input(1));
  const at::Tensor inferred = autoregressive(*distribution).log_probability(rows);
  for (std::int64_t i = 0; i < count; ++i) {
    worst = std::max(worst, std::abs(joint[0][i].item<double>() - expected[i]));
    worst = std::max(worst, std::abs(inferred[0][i].item<double>() - expected[i]));
  }
  EXPECT_LT(worst, 1e-4);
}

TEST(AutoregressiveHead, DensityOfABoxSumsOverItsDistinctVectors) {
  QuartileCodecOptions options;
  options.bins = 16;
  options.size_high = 3;
  options.center_low = -2;
  options.center_high = 2;
  const HeadContext context = {
      .features = 6, .condition = 0, .codec = std::make_shared<QuartileCodec>(options)};
  AutoregressiveHead head(small(), context);
  const auto objects = arbox::testing::random_objects(context, 20, 9);
  const auto distribution = head.forward(objects.input);
  const ComponentSet set = context.codec->equivalents(objects.boxes, objects.input.references);
  const at::Tensor bins = quantize(set.values, context.codec->components());
  const at::Tensor each =
      head.log_probability(objects.input.features, dequantize(bins, context.codec->components()));
  double log_cell = 0;
  for (const Component& component : context.codec->components()) {
    log_cell += std::log(component.step());
  }
  const at::Tensor density = distribution->log_density(objects.boxes);
  for (std::int64_t n = 0; n < 20; ++n) {
    double sum = 0;
    for (std::int64_t m = 0; m < each.size(1); ++m) {
      bool repeats = false;
      for (std::int64_t k = 0; k < m; ++k) repeats |= bins[n][m].equal(bins[n][k]);
      if (!repeats) sum += std::exp(each[n][m].item<double>() - log_cell);
    }
    EXPECT_NEAR(density[n].item<double>(), std::log(sum), 1e-3);
  }
}

TEST(AutoregressiveHead, KnownSizesStayAndTheRestIsConditionedOnThem) {
  const HeadContext context = residual_context();
  AutoregressiveHead head(small(), context);
  const auto objects = arbox::testing::random_objects(context, 6, 4);
  const at::Tensor sizes = objects.boxes.slice(1, 3, 6);
  const auto given = head.forward(objects.input)->given_sizes(sizes);
  const Draws best = given->mode({.beam_width = 3}),
              drawn = given->sample(4, {1, at::arange(6, at::kLong)});
  EXPECT_TRUE(at::allclose(best.boxes.slice(2, 3, 6), sizes.unsqueeze(1).expand({6, 3, 3})));
  EXPECT_TRUE(at::allclose(drawn.boxes.slice(2, 3, 6), sizes.unsqueeze(1).expand({6, 4, 3})));
  const at::Tensor again = given->log_density(best.boxes.select(1, 0));
  EXPECT_TRUE(at::allclose(again, best.log_density.select(1, 0), 1e-3, 1e-3));
  at::Tensor other = best.boxes.select(1, 0).clone();
  other.slice(1, 3, 6).mul_(1.2);
  EXPECT_TRUE(given->log_density(other).isinf().all().item<bool>());
}

TEST(AutoregressiveHead, RefusesWhatItCannotDo) {
  YawCodecOptions options = ResidualCodec::defaults();
  options.order = "center_size_rotation";
  HeadContext context = residual_context();
  context.codec = std::make_shared<ResidualCodec>(options);
  AutoregressiveHead head(small(), context);
  const auto objects = arbox::testing::random_objects(context, 2, 4);
  EXPECT_THROW(head.forward(objects.input)->given_sizes(objects.boxes.slice(1, 3, 6)),
               NotAvailable);
  context.codec = std::make_shared<QuartileCodec>();
  AutoregressiveOptions with_iou = small();
  with_iou.iou_weight = 1;
  EXPECT_THROW(AutoregressiveHead(with_iou, context), ConfigError);
  with_iou.hidden = {0};
  EXPECT_THROW(AutoregressiveHead(with_iou, residual_context()), ConfigError);
}

}  // namespace
