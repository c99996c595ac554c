// A head as a plugin: everything that an author writes. Build it as
// libarbox_head_linear_gaussian.so, put its folder into ARBOX_PLUGIN_PATH, and name it in a
// configuration (docs/heads.md).
#include <ATen/TensorOperators.h>
#include <ATen/ops/exp.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>

#include <cmath>
#include <utility>
#include <vector>

#include "arbox/base/plugin.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/gaussian_distribution.h"
#include "arbox/heads/head_kind.h"

namespace {

using arbox::heads::BoxDistribution;
using arbox::heads::ComponentSet;
using arbox::heads::GaussianDistribution;
using arbox::heads::HeadContext;
using arbox::heads::HeadInput;
using arbox::heads::HeadLoss;
using at::Tensor;

struct LinearGaussianOptions {
  /// Deviation of every component at the start, in ranges of the component.
  double deviation = 0.1;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "deviation", &LinearGaussianOptions::deviation,
        {.help = "Deviation at the start, in ranges of a component", .low = 1e-6, .high = 1});
  }
};

/// Linear regression: the mean of each component is linear in the features, and its deviation is
/// one learned number, the same for every object.
class LinearGaussian : public arbox::heads::BoxHead {
 public:
  LinearGaussian(const LinearGaussianOptions& options, HeadContext context)
      : context_(std::move(context)) {
    std::vector<double> middles, ranges;
    for (const auto& component : context_.codec->components()) {
      middles.push_back(0.5 * (component.low + component.high));
      ranges.push_back(component.high - component.low);
    }
    middles_ = at::tensor(middles).to(at::kFloat);
    ranges_ = at::tensor(ranges).to(at::kFloat);
    const auto width = static_cast<std::int64_t>(middles.size());
    weight_ = register_parameter("weight",
                                 0.01 * at::randn({width, context_.features + context_.condition}));
    bias_ = register_parameter("bias", at::zeros({width}));
    log_deviation_ =
        register_parameter("log_deviation", at::zeros({width}) + std::log(options.deviation));
  }

  std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override {
    input.require_valid(context_, "linear_gaussian head");
    return std::make_unique<GaussianDistribution>(mean(input), deviation(input), context_.codec,
                                                  input.references);
  }

  HeadLoss loss(const HeadInput& input, const Tensor& target_boxes) override {
    input.require_valid(context_, "linear_gaussian head");
    arbox::heads::require_targets(target_boxes, input.count(), "linear_gaussian head");
    const Tensor target =
        context_.codec->encode(target_boxes, input.references.detached()).unsqueeze(1);
    const Tensor each = arbox::heads::gaussian_log_density(target, mean(input), deviation(input),
                                                           context_.codec->components());
    const Tensor likelihood = -each.sum(-1).select(1, 0);
    return {likelihood, {{"likelihood", likelihood}}};
  }

 private:
  Tensor mean(const HeadInput& input) const {
    return middles_ + ranges_ * at::linear(input.joined(), weight_, bias_);
  }
  Tensor deviation(const HeadInput& input) const {
    return (ranges_ * at::exp(log_deviation_)).expand({input.count(), ranges_.size(0)});
  }

  HeadContext context_;
  Tensor middles_, ranges_, weight_, bias_, log_deviation_;
};

void register_linear_gaussian(arbox::Registrar& registrar) {
  registrar.add<arbox::heads::HeadKind, LinearGaussianOptions>(
      "linear_gaussian", "Linear regression with one deviation a component",
      [](const LinearGaussianOptions& options, const HeadContext& context) {
        return std::make_shared<LinearGaussian>(options, context);
      });
}

}  // namespace

ARBOX_PLUGIN("head", "linear_gaussian", "1.0.0", "Apache-2.0", register_linear_gaussian)
