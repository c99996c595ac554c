#include <ATen/Context.h>
#include <ATen/TensorOperators.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/base/plugin_loader.h"
#include "arbox/heads/head_conformance.h"
#include "arbox/heads/head_registry.h"
#include "arbox/heads/parameters.h"
#include "arbox/io/npz.h"
#include "heads/random_input.h"
#include "support/program.h"

namespace {

using namespace arbox;
using namespace arbox::heads;
using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

const fs::path kRefused = ARBOX_REFUSED_HEADS;

HeadMaker maker(const std::string& name, const std::vector<std::string>& options = {}) {
  return [name, options](const HeadContext& context) {
    ::setenv("ARBOX_PLUGIN_PATH", ARBOX_EXAMPLE_PLUGINS, 1);
    at::manual_seed(1);
    Registry registry = make_head_registry();
    auto head = make_head(name, options, context, registry);
    ::unsetenv("ARBOX_PLUGIN_PATH");
    return head;
  };
}

const std::string kHidden = "hidden=[32, 48]";
ARBOX_TEST_HEAD(Autoregressive, maker("autoregressive", {kHidden}))
ARBOX_TEST_HEAD(AutoregressiveIou, maker("autoregressive", {kHidden, "iou_weight=1"}))
ARBOX_TEST_HEAD(Discrete, maker("discrete", {kHidden}))
ARBOX_TEST_HEAD(FourPoint, maker("four_point", {kHidden}))
ARBOX_TEST_HEAD(Gaussian, maker("gaussian", {kHidden}))
ARBOX_TEST_HEAD(Pointwise, maker("pointwise", {kHidden, "loss=smooth_l1"}))
ARBOX_TEST_HEAD(PluginLinearGaussian, maker("linear_gaussian", {"deviation=0.3"}))

TEST(HeadConformance, TellsWhatIsBroken) {
  // A head whose losses look at the whole batch.
  class Broken : public BoxHead {
   public:
    explicit Broken(std::shared_ptr<BoxHead> inner) : inner_(std::move(inner)) {
      register_module("inner", inner_);
    }
    std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override {
      return inner_->forward(input);
    }
    HeadLoss loss(const HeadInput& input, const at::Tensor& boxes) override {
      HeadLoss loss = inner_->loss(input, boxes);
      loss.per_object = loss.per_object + loss.per_object.sum();
      return loss;
    }

   private:
    std::shared_ptr<BoxHead> inner_;
  };
  const auto violations = head_violations([](const HeadContext& context) {
    return std::make_shared<Broken>(maker("pointwise", {kHidden})(context));
  });
  EXPECT_THAT(violations, ::testing::Contains(HasSubstr("an object's loss depends on the batch")));
}

TEST(HeadRegistry, AHeadIsANameInAConfiguration) {
  ::setenv("ARBOX_PLUGIN_PATH", ARBOX_EXAMPLE_PLUGINS, 1);
  Registry registry = make_head_registry();
  for (const char* yaml :
       {"{name: autoregressive, options: ['hidden=[8]'], codec: {kind: residual, bins: 32}}",
        "{name: gaussian, codec: {kind: scaled, with_yaw: false}}", "{name: linear_gaussian}"}) {
    const auto config = parse_options<HeadConfig>(yaml, "model.yaml");
    const auto head = make_head(config, 6, 0, registry);
    const HeadContext context = {.features = 6, .condition = 0, .codec = make_codec(config.codec)};
    const auto objects = arbox::testing::random_objects(context, 3, 1);
    EXPECT_EQ(head->forward(objects.input)->mode({.beam_width = 1}).boxes.size(0), 3) << yaml;
  }
  EXPECT_THROW(make_head("gausian", {}, {}, registry), InvalidArgument);
  const HeadContext context = {.features = 6, .condition = 0, .codec = make_codec({})};
  EXPECT_THROW(make_head("gausian", {}, context, registry), PluginError);
  EXPECT_THROW(make_head("gaussian", {"hiden=[4]"}, context, registry), ConfigError);
  EXPECT_THROW(make_head("gaussian", {"hidden=[0]"}, context, registry), ConfigError);
  EXPECT_THROW(parse_options<HeadConfig>("{codec: {kind: polar}}", "model.yaml"), ConfigError);
  ::unsetenv("ARBOX_PLUGIN_PATH");
}

std::string refusal(const std::string& name) {
  Registry registry = make_head_registry();
  const std::size_t known = registry.entries().size();
  try {
    load_plugin(kRefused / ("libarbox_head_" + name + ".so"), registry);
    ADD_FAILURE() << name << " was loaded";
  } catch (const PluginError& error) {
    EXPECT_EQ(registry.entries().size(), known);
    return error.what();
  }
  return "";
}

TEST(HeadPlugin, WhatDoesNotFitIsRefusedWithTheReason) {
  EXPECT_THAT(refusal("abi"), HasSubstr("plugin ABI: the plugin has "));
  EXPECT_THAT(refusal("libtorch"), AllOf(HasSubstr("LibTorch: the plugin has '9.8.7', Arbox has '"),
                                         HasSubstr(TORCH_VERSION)));
  EXPECT_THAT(refusal("symbol"), HasSubstr("has no function 'arbox_plugin_register'"));
  EXPECT_THAT(refusal("taken"), HasSubstr("the head 'gaussian' is registered twice"));
  EXPECT_THAT(refusal("text"), HasSubstr("cannot be loaded"));
  EXPECT_THAT(refusal("absent"), HasSubstr("no such file"));
}

TEST(Parameters, GoThroughAFileAndBack) {
  const HeadContext context = {.features = 6, .condition = 0, .codec = make_codec({})};
  const auto first = maker("discrete", {"hidden=[8]"})(context);
  const auto second = maker("discrete", {"hidden=[8]"})(context);
  std::vector<std::pair<std::string, std::string>> arrays;
  for (const auto& [name, tensor] : parameters_of(*first)) {
    const std::vector<std::size_t> shape(tensor.sizes().begin(), tensor.sizes().end());
    const std::span values(tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel()));
    arrays.emplace_back(name, io::encode_npy<float>(values, shape));
  }
  const arbox::testing::TemporaryDirectory folder;
  const fs::path file = folder.write("head.npz", io::encode_npz(arrays));
  const io::NpzFile archive = io::open_npz(file);
  NamedTensors read;
  for (const std::string& name : archive.names()) {
    const io::NpyArray array = archive.read(name);
    const std::vector<std::int64_t> shape(array.shape().begin(), array.shape().end());
    read[name] = at::zeros(shape);
    const auto values = array.values<float>();
    std::copy(values.begin(), values.end(), read[name].data_ptr<float>());
  }
  load_parameters(*second, read, file.string());
  const auto objects = arbox::testing::random_objects(context, 5, 1);
  EXPECT_TRUE(first->forward(objects.input)
                  ->mode({.beam_width = 3})
                  .boxes.equal(second->forward(objects.input)->mode({.beam_width = 3}).boxes));
}

TEST(Parameters, WhatDoesNotFitIsListedAndNothingIsLoaded) {
  const HeadContext context = {.features = 6, .condition = 0, .codec = make_codec({})};
  const auto head = maker("pointwise", {"hidden=[8]"})(context);
  const NamedTensors before = parameters_of(*head);
  NamedTensors other = parameters_of(*head);
  for (auto& [name, tensor] : other) tensor.fill_(1);
  other.erase("layers.0.bias");
  other["layers.2.weight"] = at::zeros({7, 9});
  other["layers.2.bias"][3] = std::nan("");
  other["layers.4.bias"] = at::zeros({1});
  try {
    load_parameters(*head, other, "weights.bin");
    FAIL() << "loaded";
  } catch (const FormatError& error) {
    EXPECT_THAT(
        error.what(),
        AllOf(::testing::StartsWith("weights.bin: "), HasSubstr("'layers.0.bias' is missing"),
              HasSubstr("'layers.2.weight' has shape [7, 9], expected [7, 8]"),
              HasSubstr("'layers.2.bias' holds a non-finite number"),
              HasSubstr("'layers.4.bias' is unknown")));
  }
  for (const auto& [name, tensor] : parameters_of(*head))
    EXPECT_TRUE(tensor.equal(before.at(name)));
}

}  // namespace
