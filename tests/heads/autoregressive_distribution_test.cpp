#include "arbox/heads/autoregressive_distribution.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/full.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>
#include <torch/optim/adam.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/heads/autoregressive_head.h"
#include "arbox/heads/conditioning.h"
#include "arbox/heads/distribution_boxes.h"
#include "arbox/heads/yaw_codecs.h"
#include "heads/random_input.h"

namespace {

using namespace arbox;
using namespace arbox::heads;
using arbox::testing::normal_rows;
using at::Tensor;

/// Sizes 0.5 to 2.5 and centres -1 to 1 in `bins` steps, yaw as well if asked for.
HeadContext scaled(int bins, bool with_yaw, const std::string& order = "size_center_rotation") {
  YawCodecOptions options = ScaledCodec::defaults();
  options.order = order;
  options.bins = bins;
  options.size_low = 0.5;
  options.size_high = 2.5;
  return {.features = 4, .condition = 0, .codec = std::make_shared<ScaledCodec>(options, with_yaw)};
}

AutoregressiveOptions small_mlps() {
  AutoregressiveOptions options;
  options.hidden = {24};
  return options;
}

/// A head with larger weights than a fresh one, so that its distribution is far from uniform.
std::unique_ptr<AutoregressiveHead> opinionated(const HeadContext& context) {
  auto head = std::make_unique<AutoregressiveHead>(small_mlps(), context);
  at::NoGradGuard guard;
  std::uint64_t seed = 0;
  for (Tensor& parameter : head->parameters()) {
    const std::int64_t columns = parameter.dim() == 2 ? parameter.size(1) : 1;
    parameter.copy_(normal_rows(parameter.size(0), columns, ++seed).view_as(parameter) * 1.2);
  }
  return head;
}

/// References at the origin of scale 1: component values are metres.
HeadInput plain_input(std::int64_t count, std::uint64_t seed = 3) {
  HeadInput input;
  input.features = normal_rows(count, 4, seed);
  Tensor rotation = at::zeros({count, 4});
  rotation.select(1, 0).fill_(1.0);
  input.references = {at::zeros({count, 3}), rotation, at::ones({count, 3})};
  return input;
}

TEST(AutoregressiveDistribution, AllBeamsTogetherHaveMassOneAndMergedEndsNone) {
  const HeadContext context = scaled(4, true);
  const auto distribution = opinionated(context)->forward(plain_input(2));
  const Draws mode = distribution->mode({.beam_width = 1 << 20});
  ASSERT_EQ(mode.boxes.size(1), 4096 * 3);  // the yaw has 3 bins of 4
  double cell = 1.0;
  for (const Component& component : context.codec->components()) cell *= component.step();
  const Tensor mass = (mode.log_density.to(at::kDouble).exp() * cell).sum(1);
  EXPECT_NEAR(mass[0].item<double>(), 1.0, 1e-4);
  EXPECT_NEAR(mass[1].item<double>(), 1.0, 1e-4);
  EXPECT_LT(mode.components.select(-1, 6).max().item<double>(),
            context.codec->components()[6].high - 0.1);
  const Tensor falls = mode.log_density.slice(1, 1) <= mode.log_density.slice(1, 0, -1);
  EXPECT_TRUE(falls.all().item<bool>());
}

TEST(AutoregressiveDistribution, SizeAndRestMakeTheJointDensity) {
  const auto distribution = opinionated(scaled(3, false))->forward(plain_input(1));
  const Draws all = distribution->mode({.beam_width = 729});
  for (std::int64_t k = 0; k < 729; k += 31) {
    const Tensor box = all.boxes.select(1, k);
    const Tensor sizes = box.slice(1, 3, 6);
    const double joint = distribution->log_size_density(sizes).item<double>() +
                         distribution->given_sizes(sizes)->log_density(box).item<double>();
    EXPECT_NEAR(joint, all.log_density[0][k].item<double>(), 1e-4);
    EXPECT_NEAR(joint, distribution->log_density(box).item<double>(), 1e-4);
  }
  EXPECT_EQ(distribution->log_size_density(at::full({1, 3}, 9.0)).item<double>(),
            -std::numeric_limits<double>::infinity());
}

TEST(AutoregressiveDistribution, EntropyAndMeanAreThoseOfTheEnumeratedVectors) {
  const HeadContext context = scaled(3, false);
  const auto distribution = opinionated(context)->forward(plain_input(2));
  const Draws all = distribution->mode({.beam_width = 729});
  double cell = 1.0;
  for (const Component& component : context.codec->components()) cell *= component.step();
  const Tensor mass = all.log_density.to(at::kDouble).exp() * cell;
  const Tensor exact = -(mass * all.log_density).sum(1);
  const Tensor estimate = entropy(*distribution, 20000, {4, at::arange(2, at::kLong)});
  const Tensor mean = (mass.unsqueeze(-1) * all.boxes.to(at::kDouble)).sum(1);
  for (std::int64_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(estimate[i].item<double>(), exact[i].item<double>(), 0.05);
    // 256 draws of components that spread over 2: a deviation of at most 1 / 16.
    EXPECT_LT((distribution->mean()[i] - mean[i]).slice(0, 0, 6).abs().max().item<double>(), 0.3);
  }
}

/// Every solid among the vectors of the given size, in every order of its extents, by brute force:
/// boxes of equal centre and height whose footprints are equal, with their summed densities.
double best_by_enumeration(const BoxDistribution& distribution, std::array<double, 3> extents) {
  struct Solid {
    std::array<double, 7> key;
    double density;
  };
  std::vector<Solid> solids;
  std::sort(extents.begin(), extents.end());
  do {
    const Tensor sizes = at::tensor({extents[0], extents[1], extents[2]}, at::kDouble).view({1, 3});
    const double of_size = std::exp(distribution.log_size_density(sizes).item<double>());
    const Draws all = distribution.given_sizes(sizes)->mode({.beam_width = 1 << 20});
    const auto boxes = to_boxes(all.boxes[0]);
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      const geometry::Box& box = boxes[k];
      // The footprint as a matrix: equal for turns by half and for swapped sides. That of a square
      // does not see any turn; its corners do, modulo a quarter.
      const double c = std::cos(geometry::yaw(box)), s = std::sin(geometry::yaw(box));
      const double l = box.size.x() * box.size.x(), w = box.size.y() * box.size.y();
      const Solid solid{
          {box.center.x(), box.center.y(), box.center.z(), l * c * c + w * s * s, (l - w) * c * s,
           box.size.z(), l == w ? std::cos(4 * geometry::yaw(box)) : 0.0},
          of_size * std::exp(all.log_density[0][k].item<double>())};
      const auto same = std::find_if(solids.begin(), solids.end(), [&](const Solid& one) {
        return std::equal(one.key.begin(), one.key.end(), solid.key.begin(),
                          [](double a, double b) { return std::abs(a - b) < 1e-3; });
      });
      if (same == solids.end()) {
        solids.push_back(solid);
      } else {
        same->density += solid.density;
      }
    }
  } while (std::next_permutation(extents.begin(), extents.end()));
  return std::max_element(solids.begin(), solids.end(),
                          [](const Solid& a, const Solid& b) { return a.density < b.density; })
      ->density;
}

TEST(AutoregressiveDistribution, ConditioningFindsWhatEnumerationFinds) {
  // Five points over half a turn: a quarter turn is two of them, so that sides can be swapped.
  const auto head = opinionated(scaled(5, true));
  const std::vector<KnownSize> known{{"a", {0.5, 1.0, 2.0}}, {"b", {1.0, 1.5, 1.0}}};
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const auto distribution = head->forward(plain_input(1, seed));
    const auto found =
        given_known_sizes(*distribution, known, {.beam_width = 500, .score = "joint"}).at(0);
    EXPECT_NEAR(found.by_size[0].log_density,
                std::log(best_by_enumeration(*distribution, {0.5, 1.0, 2.0})), 1e-3);
    EXPECT_NEAR(found.by_size[1].log_density,
                std::log(best_by_enumeration(*distribution, {1.0, 1.5, 1.0})), 1e-3);
    EXPECT_NEAR(found.margin, std::abs(found.by_size[0].log_density - found.by_size[1].log_density),
                1e-9);
  }
}

TEST(AutoregressiveDistribution, ExtentsInTheirOrderKeepIt) {
  const auto distribution = opinionated(scaled(5, true))->forward(plain_input(2));
  const std::vector<KnownSize> known{{"a", {0.5, 2.0, 1.0}}};
  const auto given = given_known_sizes(*distribution, known,
                                       {.beam_width = 500, .score = "joint", .orders = "given"});
  const auto any = given_known_sizes(*distribution, known, {.beam_width = 500, .score = "joint"});
  const Tensor sizes = at::tensor({0.5, 2.0, 1.0}, at::kDouble).expand({2, 3});
  const Tensor of_size = distribution->log_size_density(sizes);
  const Draws mode = distribution->given_sizes(sizes)->mode({.beam_width = 500});
  for (std::int64_t i = 0; i < 2; ++i) {
    EXPECT_LT((given[i].box.size - known[0].size).norm(), 1e-5);
    // At least its best beam, and more if others are the same solid.
    EXPECT_GE(given[i].log_density + 1e-4, (of_size[i] + mode.log_density[i][0]).item<double>());
    EXPECT_LE(given[i].log_density, any[i].log_density + 1e-6);
  }
  EXPECT_EQ(why_not_conditioned(*distribution), "");
  EXPECT_THROW(given_known_sizes(*distribution, known, {.orders = "some"}), ConfigError);
}

TEST(AutoregressiveDistribution, OrdersWithoutTheSizeFirstAreNotConditioned) {
  const auto distribution =
      opinionated(scaled(4, true, "center_size_rotation"))->forward(plain_input(1));
  const std::vector<KnownSize> known{{"a", {0.5, 1.0, 2.0}}};
  try {
    given_known_sizes(*distribution, known);
    FAIL() << "expected a refusal";
  } catch (const NotAvailable& error) {
    EXPECT_NE(std::string(error.what()).find("does not predict the size first"), std::string::npos);
  }
  EXPECT_THROW(common_size(*distribution, std::vector<Eigen::Vector3d>{{1, 1, 1}}), NotAvailable);
  EXPECT_NE(why_not_conditioned(*distribution).find("does not predict the size first"),
            std::string::npos);
}

TEST(AutoregressiveDistribution, FollowsItsParameters) {
  const auto head = opinionated(scaled(4, false));
  const HeadInput input = plain_input(1);
  const auto before = head->forward(input)->mode({.beam_width = 1}).log_density.item<double>();
  EXPECT_EQ(head->forward(input)->mode({.beam_width = 1}).log_density.item<double>(), before);
  {
    at::NoGradGuard guard;
    for (Tensor& parameter : head->parameters()) parameter.mul_(0.5);
  }
  EXPECT_LT(head->forward(input)->mode({.beam_width = 1}).log_density.item<double>(), before);
}

TEST(AutoregressiveDistribution, OutputsThatAreNotFiniteAreDroppedAndCounted) {
  const auto head = opinionated(scaled(4, false));
  {
    at::NoGradGuard guard;
    head->parameters().back().fill_(std::nan(""));
  }
  const auto result = distribution_boxes(*head->forward(plain_input(2)),
                                         {1, at::arange(2, at::kLong)}, {.quantiles = {0.2}});
  EXPECT_EQ(result.dropped, 128);
  EXPECT_TRUE(result.objects[0].quantile_boxes.empty());
}

TEST(AutoregressiveDistribution, NoObjectsGiveNoBoxes) {
  const auto distribution = opinionated(scaled(4, true))->forward(plain_input(0));
  const std::vector<KnownSize> known{{"a", {0.5, 1.0, 2.0}}};
  EXPECT_EQ(distribution->mode({.beam_width = 5}).boxes.size(0), 0);
  EXPECT_TRUE(given_known_sizes(*distribution, known).empty());
  EXPECT_TRUE(distribution_boxes(*distribution, {1, at::arange(0, at::kLong)}).objects.empty());
}

/// Parcels 1 m wide and high with their near face at x = 0; seven in ten are 2 m long and three in
/// ten 2.5 m.
struct Parcels {
  HeadContext context = scaled(17, false);
  HeadInput input;
  Tensor boxes;

  Parcels() : input(plain_input(100)), boxes(at::zeros({100, 10})) {
    input.features = at::ones({100, 4});
    for (std::int64_t i = 0; i < 100; ++i) {
      const double length = i < 70 ? 2.0 : 2.5;
      const std::vector<geometry::Box> box{
          geometry::make_yaw_box({length / 2 - 0.75, 0, 0}, {length, 1, 1}, 0)};
      boxes[i] = to_tensor(box)[0];
    }
  }
};

TEST(AutoregressiveDistribution, ATrainedHeadPlacesABoxOfKnownSize) {
  const Parcels parcels;
  const auto head = opinionated(parcels.context);
  torch::optim::Adam optimizer(head->parameters(), torch::optim::AdamOptions(0.01));
  for (int step = 0; step < 600; ++step) {
    optimizer.zero_grad();
    head->loss(parcels.input, parcels.boxes).per_object.mean().backward();
    optimizer.step();
  }
  HeadInput one = parcels.input.select(at::arange(1, at::kLong));
  const auto distribution = head->forward(one);
  const std::vector<KnownSize> known{{"long", {1, 1, 2.5}}, {"short", {1, 1, 2}}};
  const auto both = given_known_sizes(*distribution, known, {.score = "joint"}).at(0);
  EXPECT_EQ(both.known_size, 1u);
  EXPECT_NEAR(both.margin, std::log(0.7 / 0.3), 0.2);
  const geometry::Box& long_box = both.by_size[0].box;
  EXPECT_NEAR(long_box.size.x(), 2.5, 1e-6);
  EXPECT_NEAR(long_box.center.x(), 0.5, 0.07);  // half a bin
  EXPECT_NEAR(both.box.center.x(), 0.25, 0.07);
  const auto draws = draw_sizes(*distribution, 10, {1, at::arange(1, at::kLong)});
  const CommonSize common = common_size(*distribution, draws);
  EXPECT_NEAR(draws[common.candidate].maxCoeff(), 2.0, 1e-5);
}

}  // namespace
