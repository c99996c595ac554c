#include <ATen/TensorOperators.h>
#include <ATen/ops/abs.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/geometry/box.h"
#include "arbox/geometry/rotation.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/quantizer.h"
#include "arbox/heads/quartile_codec.h"
#include "arbox/heads/yaw_codecs.h"

namespace {

using namespace arbox;
using namespace arbox::heads;

constexpr double kPi = std::numbers::pi;

/// Boxes and references of many objects: the boxes stand near their reference.
struct Case {
  std::vector<geometry::Box> boxes;
  References references;
};

Case make_case(bool yaw_only, std::uint64_t seed) {
  const RandomStream random(seed, 0, 0);
  std::uint32_t draw = 0;
  const auto uniform = [&](double low, double high) { return random.uniform(draw++, low, high); };
  Case result;
  std::vector<geometry::Box> frames;
  for (int i = 0; i < 200; ++i) {
    const geometry::Box frame = geometry::make_yaw_box(
        {uniform(-50, 50), uniform(-50, 50), uniform(-2, 2)},
        {uniform(3, 5), uniform(1, 2), uniform(1, 2)}, yaw_only ? uniform(-3, 3) : 0.0);
    frames.push_back(frame);
    geometry::Box box = geometry::make_yaw_box(
        frame.center + Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-0.5, 0.5)),
        frame.size * uniform(0.8, 1.2), geometry::yaw(frame) + uniform(-1.5, 1.5));
    if (!yaw_only) {
      box.rotation = geometry::Quaternion(random.normal(draw + 1), random.normal(draw + 2),
                                          random.normal(draw + 3), random.normal(draw + 4))
                         .normalized();
      draw += 5;
    }
    result.boxes.push_back(box);
  }
  const at::Tensor rows = to_tensor(frames, at::kDouble);
  result.references = {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
  return result;
}

/// The largest distance from a corner of one box to the nearest corner of the other.
double shape_distance(const geometry::Box& a, const geometry::Box& b) {
  double worst = 0;
  for (const auto& corner : geometry::corners(a)) {
    double nearest = 1e30;
    for (const auto& other : geometry::corners(b)) {
      nearest = std::min(nearest, (corner - other).norm());
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

void expect_same_shapes(const BoxCodec& codec, bool yaw_only) {
  const Case data = make_case(yaw_only, 3);
  const at::Tensor boxes = to_tensor(data.boxes, at::kDouble);
  const ComponentSet set = codec.equivalents(boxes, data.references);
  const at::Tensor decoded = codec.decode(set.values, data.references);
  ASSERT_TRUE(set.mask.any(-1).all().item<bool>());
  for (std::int64_t m = 0; m < decoded.size(1); ++m) {
    const auto back = to_boxes(decoded.select(1, m));
    for (std::size_t i = 0; i < back.size(); ++i) {
      ASSERT_LT(shape_distance(back[i], data.boxes[i]), 1e-9) << "box " << i << ", vector " << m;
    }
  }
  const auto back =
      to_boxes(codec.decode(codec.encode(boxes, data.references).unsqueeze(1), data.references)
                   .select(1, 0));
  for (std::size_t i = 0; i < back.size(); ++i) {
    ASSERT_LT(shape_distance(back[i], data.boxes[i]), 1e-9) << "box " << i;
  }
}

YawCodecOptions every_equivalent(YawCodecOptions options) {
  options.full_turn = options.half_turn_equivalent = options.quarter_turn_equivalent = true;
  return options;
}

TEST(Codec, EveryEquivalentVectorDecodesToTheSameBox) {
  expect_same_shapes(ResidualCodec(), true);
  expect_same_shapes(ResidualCodec(every_equivalent(ResidualCodec::defaults())), true);
  expect_same_shapes(ScaledCodec(), true);
  expect_same_shapes(ScaledCodec(every_equivalent(ScaledCodec::defaults())), true);
  for (const char* set : {"one", "canonical", "all"}) {
    expect_same_shapes(QuartileCodec({.equivalents = set}), false);
  }
  const QuartileCodec center_first({.order = "center_size_rotation"});
  expect_same_shapes(center_first, false);
  EXPECT_EQ(center_first.size_components(), (std::vector<int>{3, 4, 5}));
  EXPECT_EQ(center_first.components()[3].name, "length");
  EXPECT_THROW(QuartileCodec({.order = "rotation_first"}), ConfigError);
}

TEST(Codec, EquivalentSetsHaveTheDocumentedSizes) {
  const Case data = make_case(true, 4);
  const at::Tensor boxes = to_tensor(data.boxes, at::kDouble);
  EXPECT_EQ(ResidualCodec().equivalents(boxes, data.references).values.size(1), 1);
  EXPECT_EQ(ResidualCodec(every_equivalent(ResidualCodec::defaults()))
                .equivalents(boxes, data.references)
                .values.size(1),
            4);
  EXPECT_EQ(QuartileCodec().equivalents(boxes, data.references).values.size(1), 6);
  EXPECT_EQ(
      QuartileCodec({.equivalents = "all"}).equivalents(boxes, data.references).values.size(1), 24);
}

TEST(Codec, ResidualsAreThoseOfThePublishedCoder) {
  const std::vector<geometry::Box> roi = {geometry::make_yaw_box({10, 5, -1}, {4, 3, 2}, 0.5)};
  const at::Tensor rows = to_tensor(roi, at::kDouble);
  const References references{rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
  // One metre along the RoI's own length, half a metre up, twice as long, a tenth of a radian on.
  const std::vector<geometry::Box> box = {
      geometry::make_yaw_box({10 + std::cos(0.5), 5 + std::sin(0.5), -0.5}, {8, 3, 2}, 0.6)};
  const at::Tensor code = ResidualCodec().encode(to_tensor(box, at::kDouble), references);
  const std::vector<double> expected = {std::log(2.0), 0, 0, 0.2, 0, 0.25, 0.1};
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(code[0][i].item<double>(), expected[static_cast<std::size_t>(i)], 1e-12) << i;
  }
  YawCodecOptions published = ResidualCodec::defaults();
  published.order = "center_size_rotation";
  const at::Tensor other = ResidualCodec(published).encode(to_tensor(box, at::kDouble), references);
  EXPECT_NEAR(other[0][0].item<double>(), 0.2, 1e-12);
  EXPECT_NEAR(other[0][3].item<double>(), std::log(2.0), 1e-12);
  EXPECT_EQ(ResidualCodec(published).size_components(), (std::vector<int>{3, 4, 5}));
}

TEST(Codec, ScaleKeepsItsGradient) {
  const Case data = make_case(true, 5);
  at::Tensor scale = at::ones({200, 3}, at::kDouble).mul_(4).requires_grad_(true);
  References references = data.references;
  references.size = scale;
  ScaledCodec().encode(to_tensor(data.boxes, at::kDouble), references).sum().backward();
  EXPECT_GT(scale.grad().abs().sum().item<double>(), 0.0);
}

TEST(Quantizer, BinsArePointsAndRoundHalvesToEven) {
  const std::vector<Component> components = {{"a", 0.0, 4.0, 5, false}};
  const at::Tensor values = at::tensor({-1.0, 0.4, 0.5, 1.5, 2.5, 9.0}).unsqueeze(-1);
  const at::Tensor bins = quantize(values, components);
  const std::vector<std::int64_t> expected = {0, 0, 0, 2, 2, 4};
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(bins[i][0].item<std::int64_t>(), expected[static_cast<std::size_t>(i)]) << i;
  }
  EXPECT_EQ(overflows(values, components).sum().item<std::int64_t>(), 2);
}

TEST(Quantizer, CircularEndsAreMergedOrDistinct) {
  const std::vector<Component> components = {{"angle", 0.0, 2 * kPi, 512, true}};
  const at::Tensor values = at::tensor({2 * kPi - 1e-4}, at::kDouble).unsqueeze(-1);
  EXPECT_EQ(quantize(values, components).item<std::int64_t>(), 0);
  EXPECT_EQ(quantize(values, components, CircularEnds::kDistinct).item<std::int64_t>(), 511);
}

TEST(Quantizer, QuantisedValuesAreWithinHalfAStep) {
  const Case data = make_case(false, 6);
  QuartileCodec codec;
  const at::Tensor values = codec.encode(to_tensor(data.boxes, at::kDouble), data.references);
  const at::Tensor back =
      dequantize(quantize(values, codec.components(), CircularEnds::kDistinct), codec.components());
  for (std::size_t i = 0; i < codec.components().size(); ++i) {
    const auto column = static_cast<std::int64_t>(i);
    EXPECT_LE(at::abs(back.select(1, column) - values.select(1, column)).max().item<double>(),
              0.5 * codec.components()[i].step() + 1e-6);
  }
}

// Boxes on the ground under a crop that is upright: their beta is 0, pi / 2 or pi, and rounding
// must neither tilt them nor choose their label.
TEST(Codec, UprightBoxesHaveBetaOnABin) {
  const std::int64_t count = 200;
  const Case data = make_case(true, 8);
  const at::Tensor boxes = to_tensor(data.boxes, at::kFloat);
  for (const int bins : {64, 511, 512}) {
    const QuartileCodec codec({.bins = bins});
    const ComponentSet set = codec.equivalents(boxes, data.references.detached());
    const at::Tensor beta = set.values.slice(-1, 7, 8);
    const std::vector<Component> component = {codec.components()[7]};
    const at::Tensor error = (dequantize(quantize(beta, component), component) - beta).abs();
    EXPECT_LT(error.max().item<double>(), 2e-3) << bins;
    EXPECT_EQ(error.numel(), count * 6);
  }
  const QuartileCodec published({.beta_high = kPi});
  EXPECT_EQ(published.components()[7].high, kPi);
}

TEST(Codec, EmptyBatchesAndBadShapesAreDefined) {
  const References none{at::zeros({0, 3}), at::zeros({0, 4}), at::zeros({0, 3})};
  EXPECT_EQ(QuartileCodec().encode(at::zeros({0, 10}), none).size(0), 0);
  EXPECT_EQ(ResidualCodec().encode(at::zeros({0, 10}), none).size(0), 0);
  EXPECT_THROW(ResidualCodec().encode(at::zeros({2, 10}), {}), InvalidArgument);
  EXPECT_THROW(ResidualCodec().encode(at::zeros({2, 7}), none), InvalidArgument);
}

}  // namespace
