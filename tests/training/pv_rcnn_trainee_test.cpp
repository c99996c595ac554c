#include "arbox/training/pv_rcnn_trainee.h"

#include <ATen/TensorOperators.h>
#include <gmock/gmock.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>
#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/model.h"
#include "training/made_scene.h"
#include "training/tiny_network.h"

namespace arbox::training {
namespace {

PvRcnnTraineeOptions tiny_options() {
  PvRcnnTraineeOptions options;
  options.network = tiny_network();
  options.network.head.name = "autoregressive";
  options.augmentation.objects.counts = {3, 3};
  return options;
}

std::map<std::string, double> gradient_norms(torch::nn::Module& network) {
  std::map<std::string, double> result;
  for (const auto& parameter : network.named_parameters()) {
    const at::Tensor& gradient = parameter.value().grad();
    result[parameter.key()] = gradient.defined() ? gradient.norm().item<double>() : 0.0;
  }
  return result;
}

StepLoss step(PvRcnnTrainee& trainee, const std::vector<Scene>& scenes) {
  Communicator alone;
  trainee.network().zero_grad();
  StepLoss loss = trainee.loss(scenes, {.number = 0, .seed = 3, .first_scene = 10}, alone);
  loss.total.backward();
  return loss;
}

TEST(PvRcnnTrainee, TheLossIsTheSumOfItsTerms) {
  PvRcnnTrainee trainee(tiny_options());
  trainee.network().train();
  const StepLoss loss = step(trainee, {made_scene(1), made_scene(2)});
  double sum = 0;
  for (const char* term : {"classification", "box", "direction", "keypoint", "confidence",
                           "residual", "corner", "head autoregressive"}) {
    ASSERT_TRUE(loss.terms.contains(term)) << term;
    sum += loss.terms.at(term);
  }
  EXPECT_NEAR(loss.total.item<double>(), sum, 1e-4 * sum);
  EXPECT_GT(loss.terms.at("classification"), 0);
  for (const auto& [name, norm] : gradient_norms(trainee.network())) {
    EXPECT_TRUE(std::isfinite(norm)) << name;
  }
}

}  // namespace
}  // namespace arbox::training
