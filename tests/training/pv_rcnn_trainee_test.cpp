#include "arbox/training/pv_rcnn_trainee.h"

#include <ATen/Context.h>
#include <ATen/TensorOperators.h>
#include <gmock/gmock.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>
#include <memory>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/model.h"
#include "support/program.h"
#include "training/made_scene.h"
#include "training/tiny_network.h"

namespace arbox::training {
namespace {

using ::testing::HasSubstr;

void set_seed(std::uint64_t seed) {
  at::Generator generator = at::globalContext().defaultGenerator(at::kCPU);
  generator.set_current_seed(seed);
}

PvRcnnTraineeOptions tiny_options() {
  PvRcnnTraineeOptions options;
  options.network = tiny_network();
  options.network.head.name = "autoregressive";
  options.augmentation.objects.counts = {3, 3};
  return options;
}

std::unique_ptr<PvRcnnTrainee> tiny_trainee(const PvRcnnTraineeOptions& options = tiny_options()) {
  set_seed(1);
  auto trainee = std::make_unique<PvRcnnTrainee>(options);
  trainee->network().train();
  return trainee;
}

StepLoss step(PvRcnnTrainee& trainee, const std::vector<Scene>& scenes,
              std::int64_t first_scene = 10) {
  Communicator alone;
  trainee.network().zero_grad();
  StepLoss loss = trainee.loss(scenes, {.number = 0, .seed = 3, .first_scene = first_scene}, alone);
  loss.total.backward();
  return loss;
}

double norm_below(torch::nn::Module& network, const std::string& part) {
  double sum = 0;
  for (const auto& parameter : network.named_parameters()) {
    const at::Tensor& gradient = parameter.value().grad();
    if (parameter.key().starts_with(part) && gradient.defined()) {
      sum += gradient.norm().item<double>();
    }
  }
  return sum;
}

void freeze(torch::nn::Module& network, const std::string& part) {
  for (auto& parameter : network.named_parameters()) {
    if (parameter.key().starts_with(part)) parameter.value().set_requires_grad(false);
  }
  for (auto& module : network.named_modules()) {
    if (module.key().starts_with(part)) module.value()->eval();
  }
}

TEST(PvRcnnTrainee, TheLossIsTheSumOfItsTermsAndAllOfThemLearn) {
  const auto made = tiny_trainee();
  PvRcnnTrainee& trainee = *made;
  const StepLoss loss = step(trainee, {made_scene(1), made_scene(2)});
  double sum = 0;
  for (const char* term : {"classification", "box", "direction", "keypoint", "confidence",
                           "residual", "corner", "head autoregressive"}) {
    ASSERT_TRUE(loss.terms.contains(term)) << term;
    sum += loss.terms.at(term);
  }
  EXPECT_NEAR(loss.total.item<double>(), sum, 1e-4 * sum);
  for (const char* part : {"backbone_3d", "backbone_2d", "dense_head", "pfe", "point_head",
                           "roi_head.shared_fc_layer", "roi_head.cls_layers"}) {
    EXPECT_GT(norm_below(trainee.network(), part), 0) << part;
  }
}

TEST(PvRcnnTrainee, FrozenPartsRunWithoutGradientAndTheirLossesAreLeftOut) {
  const auto made = tiny_trainee();
  PvRcnnTrainee& trainee = *made;
  for (const char* part : {"backbone_3d", "backbone_2d", "dense_head"}) {
    freeze(trainee.network(), part);
  }
  StepLoss loss = step(trainee, {made_scene(1)});
  EXPECT_FALSE(loss.terms.contains("classification"));
  EXPECT_TRUE(loss.terms.contains("keypoint"));
  EXPECT_EQ(norm_below(trainee.network(), "backbone_3d"), 0);
  EXPECT_GT(norm_below(trainee.network(), "pfe"), 0);
  for (const char* part : {"pfe", "point_head", "roi_head.roi_grid", "roi_head.shared",
                           "roi_head.cls", "roi_head.reg"}) {
    freeze(trainee.network(), part);
  }
  loss = step(trainee, {made_scene(1)});
  EXPECT_FALSE(loss.terms.contains("keypoint"));
  EXPECT_TRUE(loss.terms.contains("head autoregressive"));
  EXPECT_EQ(norm_below(trainee.network(), "pfe"), 0);
}

TEST(PvRcnnTrainee, SeveralHeadsLearnSideBySide) {
  PvRcnnTraineeOptions options = tiny_options();
  options.network.more_heads = {"gaussian", "discrete", "pointwise"};
  options.network.more_head_options = {"discrete.hidden=[16]", "gaussian.hidden=[16]"};
  const auto made = tiny_trainee(options);
  PvRcnnTrainee& trainee = *made;
  const StepLoss loss = step(trainee, {made_scene(1)});
  EXPECT_TRUE(loss.terms.contains("head gaussian"));
  EXPECT_TRUE(loss.terms.contains("head discrete"));
  EXPECT_TRUE(loss.terms.contains("discrete likelihood"));
  EXPECT_FALSE(loss.terms.contains("head pointwise")) << "it learns by the residuals' losses";
  EXPECT_EQ(trainee.detector()->heads().size(), 4u);
  trainee.network().eval();
  const auto figures = trainee.evaluate(ListedScenes({made_scene(1)}));
  for (const char* head : {"autoregressive", "gaussian", "discrete", "pointwise"}) {
    EXPECT_TRUE(figures.contains(std::string(head) + ": Car 3d R40 moderate")) << head;
    EXPECT_TRUE(figures.contains(std::string(head) + ": Pedestrian found")) << head;
  }
}

TEST(PvRcnnTrainee, EmptyScansAndScansWithoutObjectsGiveFiniteLosses) {
  const auto made = tiny_trainee();
  PvRcnnTrainee& trainee = *made;
  Scene without = made_scene(3);
  without.objects.clear();
  Scene empty;
  empty.cloud.channels = {"intensity"};
  for (const auto& scenes : {std::vector{without}, std::vector{empty, made_scene(3)},
                             std::vector{empty}, std::vector{empty, empty}}) {
    const StepLoss loss = step(trainee, scenes);
    EXPECT_TRUE(std::isfinite(loss.total.item<double>()));
    for (const auto& parameter : trainee.network().parameters()) {
      if (!parameter.grad().defined()) continue;
      EXPECT_TRUE(parameter.grad().isfinite().all().item<bool>());
    }
  }
}

TEST(PvRcnnTrainee, ObjectsOutsideOfTheRangeAreNoTargets) {
  const auto made = tiny_trainee();
  PvRcnnTrainee& trainee = *made;
  Scene far = made_scene(4), none = far;
  for (SceneObject& object : far.objects) object.box.center.x() += 40;
  none.objects.clear();
  trainee.network().eval();
  EXPECT_EQ(step(trainee, {far}).total.item<double>(), step(trainee, {none}).total.item<double>());
}

/// The sums of another process, which works on other scenes of the same batch.
class OtherProcess : public Communicator {
 public:
  explicit OtherProcess(at::Tensor counts) : counts_(std::move(counts)) {}
  int size() const override { return 2; }
  void sum(at::Tensor& tensor) override { tensor += counts_; }

 private:
  at::Tensor counts_;
};

/// Notes the counts of this process.
class Listener : public Communicator {
 public:
  void sum(at::Tensor& tensor) override { counts = tensor.clone(); }
  at::Tensor counts;
};

TEST(PvRcnnTrainee, TheSharesOfTwoProcessesAddUpToTheWholeBatch) {
  const auto made = tiny_trainee();
  PvRcnnTrainee& trainee = *made;
  trainee.network().eval();
  const Scene first = made_scene(5), second = made_scene(6, 200);
  const Step whole{.number = 0, .seed = 3, .first_scene = 20}, rest{0, 3, 21};
  Communicator alone;
  const StepLoss both = trainee.loss(std::vector{first, second}, whole, alone);
  Listener one, two;
  trainee.loss(std::vector{first}, whole, one);
  trainee.loss(std::vector{second}, rest, two);
  OtherProcess with_two(two.counts), with_one(one.counts);
  const StepLoss left = trainee.loss(std::vector{first}, whole, with_two);
  const StepLoss right = trainee.loss(std::vector{second}, rest, with_one);
  EXPECT_NEAR(left.total.item<double>() + right.total.item<double>(), both.total.item<double>(),
              1e-4 * both.total.item<double>());
  for (const auto& [name, value] : both.terms) {
    EXPECT_NEAR(left.terms.at(name) + right.terms.at(name), value, 1e-4 * (1 + std::abs(value)))
        << name;
  }
}

TEST(PvRcnnTrainee, SavedModelsHoldTheWeightsOfEveryHead) {
  PvRcnnTraineeOptions options = tiny_options();
  options.network.more_heads = {"gaussian"};
  options.network.more_head_options = {"gaussian.hidden=[24]"};
  const auto made = tiny_trainee(options);
  PvRcnnTrainee& trainee = *made;
  const arbox::testing::TemporaryDirectory folder;
  trainee.save(folder / "model.arbox");
  using detectors::pv_rcnn::load_model;
  const auto own = load_model(folder / "model.arbox");
  EXPECT_EQ(&own.network->head(), own.network->heads()[0].second.get());
  const auto further = load_model(folder / "model.arbox", {"post.head=gaussian"});
  ASSERT_EQ(further.network->heads().size(), 2u);
  EXPECT_EQ(&further.network->head(), further.network->heads()[1].second.get());
  const auto expected = trainee.detector()->heads()[1].second->parameters();
  const auto found = further.network->head().parameters();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_TRUE(found[i].equal(expected[i]));
}

TEST(PvRcnnTrainee, PreparesScenesByAugmentationWithObjectsOfItsSource) {
  PvRcnnTraineeOptions options = tiny_options();
  const ListedScenes scenes({made_scene(7), made_scene(8)});
  set_seed(1);
  const PvRcnnTrainee trainee(options, &scenes);
  Scene scene = made_scene(9);
  const std::size_t before = scene.objects.size();
  trainee.prepare(scene, 1, 2);
  EXPECT_GT(scene.objects.size(), before);
}

TEST(PvRcnnTrainee, RefusesOptionsThatDoNotFit) {
  PvRcnnTraineeOptions options = tiny_options();
  const auto expect_refused = [&](const char* part) {
    try {
      const PvRcnnTrainee trainee(options);
      ADD_FAILURE() << "expected a ConfigError with " << part;
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
    options = tiny_options();
  };
  options.network.more_heads = {"gaussian", "gaussian"};
  expect_refused("gaussian");
  options.network.more_heads = {"autoregressive"};
  expect_refused("autoregressive");
  options.network.more_head_options = {"gaussian.hidden=[16]"};
  expect_refused("more_head_options");
  options.network.post.head = "gausian";
  options.network.more_heads = {"gaussian"};
  expect_refused("nearest is 'gaussian'");
  options.augmentation.objects.counts = {1, 2, 3};
  expect_refused("augmentation.objects.counts");
  options.losses.focal_alpha = 2;
  expect_refused("focal_alpha");
}

}  // namespace
}  // namespace arbox::training
