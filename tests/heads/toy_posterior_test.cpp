#include <gtest/gtest.h>
#include <torch/utils.h>

#include "arbox/examples/toy_posterior/toy.h"
#include "arbox/heads/head_registry.h"

namespace {

using namespace arbox;
using namespace arbox::examples;

double distance_after_training(const std::string& name, const std::vector<std::string>& options) {
  torch::manual_seed(1);
  Registry registry = heads::make_head_registry();
  const auto head = heads::make_head(name, options, toy_context(), registry);
  fit(*head, 800, 512);
  return total_variation(joint_of(*head), toy_joint());
}

// The truth is correlated, bimodal and rotationally symmetric.
TEST(ToyPosterior, AutoregressiveHeadRecoversTheJoint) {
  EXPECT_LT(distance_after_training("autoregressive", {"hidden=[64, 64]"}), 0.05);
}

TEST(ToyPosterior, IndependentHeadsCannot) {
  EXPECT_GT(distance_after_training("discrete", {"hidden=[64, 64]"}), 0.3);
  EXPECT_GT(distance_after_training("gaussian", {"hidden=[64, 64]"}), 0.3);
}

// No product of marginals comes nearer than this: what the discrete head falls short of is the
// family, not the training.
TEST(ToyPosterior, DiscreteHeadReachesTheMarginals) {
  const ToyJoint truth = toy_joint();
  std::vector<double> length(kLengths), position(kPositions), heading(kHeadings);
  for (std::size_t cell = 0; cell < truth.size(); ++cell) {
    length[cell / (kPositions * kHeadings)] += truth[cell];
    position[cell / kHeadings % kPositions] += truth[cell];
    heading[cell % kHeadings] += truth[cell];
  }
  ToyJoint product;
  for (const double a : length) {
    for (const double b : position) {
      for (const double c : heading) product.push_back(a * b * c);
    }
  }
  torch::manual_seed(1);
  Registry registry = heads::make_head_registry();
  const auto head = heads::make_head("discrete", {"hidden=[32]"}, toy_context(), registry);
  fit(*head, 400, 512);
  EXPECT_LT(total_variation(joint_of(*head), product), 0.05);
}

}  // namespace
