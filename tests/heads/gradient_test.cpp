#include <ATen/Context.h>
#include <ATen/TensorOperators.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "arbox/heads/autoregressive_head.h"
#include "arbox/heads/discrete_head.h"
#include "arbox/heads/four_point_head.h"
#include "arbox/heads/gaussian_head.h"
#include "arbox/heads/pointwise_head.h"
#include "arbox/heads/quartile_codec.h"
#include "arbox/heads/yaw_codecs.h"
#include "heads/random_input.h"

namespace {

using namespace arbox;
using namespace arbox::heads;

HeadContext residual() {
  YawCodecOptions options = ResidualCodec::defaults();
  options.bins = 24;
  options.full_turn = options.half_turn_equivalent = true;
  return {.features = 5, .condition = 2, .codec = std::make_shared<ResidualCodec>(options)};
}

HeadContext quartile() {
  QuartileCodecOptions options;
  options.bins = 24;
  return {.features = 5, .condition = 0, .codec = std::make_shared<QuartileCodec>(options)};
}

double slope(double& number, const std::function<double()>& loss) {
  constexpr double kStep = 1e-6;
  const double here = number;
  number = here + kStep;
  const double up = loss();
  number = here - kStep;
  const double down = loss();
  number = here;
  return (up - down) / (2 * kStep);
}

/// Compares the gradient with central differences at some entries of every tensor, in double.
void expect_exact_gradient(BoxHead& head, const HeadContext& context,
                           bool through_references = false) {
  head.to(at::kDouble);
  auto objects = arbox::testing::random_objects(context, 6, 21, at::kDouble);
  std::vector<at::Tensor> tensors = head.parameters();
  tensors.push_back(objects.input.features.requires_grad_());
  if (objects.input.condition.defined()) {
    tensors.push_back(objects.input.condition.requires_grad_());
  }
  if (through_references) {
    objects.input.references.origin = objects.input.references.origin.clone();
    objects.input.references.size = objects.input.references.size.clone();
    tensors.push_back(objects.input.references.origin.requires_grad_());
    tensors.push_back(objects.input.references.size.requires_grad_());
  }
  const auto weights = arbox::testing::normal_rows(1, 6, 3, at::kDouble).abs().reshape(-1);
  const auto loss = [&] {
    return (head.loss(objects.input, objects.boxes).per_object * weights).sum();
  };
  loss().backward();
  int nonzero = 0;
  for (const at::Tensor& tensor : tensors) {
    const at::Tensor gradient = tensor.grad();
    ASSERT_TRUE(gradient.defined());
    for (std::uint32_t draw = 0; draw < 3; ++draw) {
      const std::uint32_t entry = RandomStream(8, static_cast<std::uint64_t>(tensor.numel()), 0)
                                      .below(draw, static_cast<std::uint32_t>(tensor.numel()));
      const double numeric =
          slope(tensor.data_ptr<double>()[entry], [&] { return loss().item<double>(); });
      const double exact = gradient.contiguous().data_ptr<double>()[entry];
      ASSERT_NEAR(exact, numeric, 1e-6 * std::max(1.0, std::abs(numeric)))
          << "tensor of shape " << tensor.sizes() << ", entry " << entry;
      nonzero += exact != 0;
    }
  }
  EXPECT_GT(nonzero, 10);
}

class Gradient : public ::testing::Test {
 protected:
  void SetUp() override { at::manual_seed(1); }
};

TEST_F(Gradient, AutoregressiveLikelihood) {
  AutoregressiveOptions options;
  options.hidden = {8, 8};
  options.reduction = Reduction::kSum;
  options.likelihood_weight = 1;
  AutoregressiveHead upright(options, residual()), free(options, quartile());
  expect_exact_gradient(upright, residual());
  expect_exact_gradient(free, quartile());
}

TEST_F(Gradient, AutoregressiveIouOfExpectations) {
  AutoregressiveOptions options;
  options.hidden = {8, 8};
  options.likelihood_weight = 0;
  options.iou_weight = 1;
  options.iou_samples = 3;
  AutoregressiveHead head(options, residual());
  expect_exact_gradient(head, residual(), true);
}

TEST_F(Gradient, Pointwise) {
  for (const PointLoss loss : {PointLoss::kL1, PointLoss::kSmoothL1}) {
    for (const Supervision supervision :
         {Supervision::kCanonical, Supervision::kNearest, Supervision::kAll}) {
      PointwiseOptions options;
      options.hidden = {8, 8};
      options.loss = loss;
      options.supervision = supervision;
      PointwiseHead head(options, quartile());
      expect_exact_gradient(head, quartile());
    }
  }
}

TEST_F(Gradient, Gaussian) {
  GaussianOptions options;
  options.hidden = {8, 8};
  GaussianHead upright(options, residual()), free(options, quartile());
  expect_exact_gradient(upright, residual());
  expect_exact_gradient(free, quartile());
}

TEST_F(Gradient, Discrete) {
  DiscreteOptions options;
  options.hidden = {8, 8};
  DiscreteHead head(options, residual());
  expect_exact_gradient(head, residual());
}

TEST_F(Gradient, FourPoint) {
  for (const PointLoss loss : {PointLoss::kL1, PointLoss::kSmoothL1}) {
    FourPointOptions options;
    options.hidden = {8, 8};
    options.loss = loss;
    FourPointHead head(options, quartile());
    expect_exact_gradient(head, quartile());
  }
}

}  // namespace
