#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/supervision.h"

namespace arbox::heads {

class MultilayerPerceptron;

struct GaussianOptions {
  std::vector<std::int64_t> hidden = {128, 256, 512};
  Reduction reduction = Reduction::kMean;
  double likelihood_weight = 0.1;
  /// Of the components over half of their range. A logistic curve keeps the variance between them,
  /// so that its gradient never vanishes.
  double log_variance_low = -14.0, log_variance_high = 2.0;
  Supervision supervision = Supervision::kNearest;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("hidden", &GaussianOptions::hidden,
                  {.help = "Widths of the hidden layers", .low = 1, .high = 65536});
    visitor.field(
        "reduction", &GaussianOptions::reduction,
        {.help = "How the components' likelihoods are reduced", .choices = {"sum", "mean"}});
    visitor.field("likelihood_weight", &GaussianOptions::likelihood_weight,
                  {.help = "Weight of the likelihood", .low = 0});
    visitor.field("log_variance_low", &GaussianOptions::log_variance_low,
                  {.help = "Least log variance, in half ranges", .low = -40, .high = 2});
    visitor.field("log_variance_high", &GaussianOptions::log_variance_high,
                  {.help = "Greatest log variance, in half ranges", .low = -40, .high = 2});
    visitor.field("supervision", &GaussianOptions::supervision,
                  {.help = "Supervised vectors where a box has several",
                   .choices = {"canonical", "nearest", "all"}});
  }
};

/// Predicts mean and variance of each component, which are independent normals (the Gaussian
/// baseline of the paper, section 5); angles are wrapped. Parameters: layers.{0,2,...}; the first D
/// outputs are means over half of the range from its middle, the others log variances. Loss:
/// likelihood_weight times the negative log likelihood of the vector, nats; term "likelihood"
/// without weight.
class GaussianHead : public BoxHead {
 public:
  /// Throws ConfigError for options out of range and log_variance_low >= log_variance_high.
  GaussianHead(GaussianOptions options, HeadContext context);

  std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override;
  HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) override;

 private:
  /// Mean and deviation (N, D).
  std::pair<at::Tensor, at::Tensor> predict(const HeadInput& input) const;

  GaussianOptions options_;
  HeadContext context_;
  std::shared_ptr<MultilayerPerceptron> layers_;
};

}  // namespace arbox::heads
