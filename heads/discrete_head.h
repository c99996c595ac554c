#pragma once

#include <memory>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/quantizer.h"
#include "arbox/heads/supervision.h"

namespace arbox::heads {

class MultilayerPerceptron;

struct DiscreteOptions {
  std::vector<std::int64_t> hidden = {128, 256, 512};
  Reduction reduction = Reduction::kMean;
  double likelihood_weight = 0.1;
  CircularEnds circular_ends = CircularEnds::kMerged;
  Supervision supervision = Supervision::kAll;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "hidden", &DiscreteOptions::hidden,
        {.help = "Widths of the hidden layers of each component's MLP", .low = 1, .high = 65536});
    visitor.field(
        "reduction", &DiscreteOptions::reduction,
        {.help = "How the components' likelihoods are reduced", .choices = {"sum", "mean"}});
    visitor.field("likelihood_weight", &DiscreteOptions::likelihood_weight,
                  {.help = "Weight of the likelihood", .low = 0});
    visitor.field("circular_ends", &DiscreteOptions::circular_ends,
                  {.help = "The two end bins of an angle: one bin or two",
                   .choices = {"merged", "distinct"}});
    visitor.field("supervision", &DiscreteOptions::supervision,
                  {.help = "Supervised vectors where a box has several",
                   .choices = {"canonical", "nearest", "all"}});
  }
};

/// Predicts bins of each component independently of the others (the discrete baseline of the paper,
/// section 5): an autoregressive head that does not look at what came before. Parameters:
/// components.{component}.{0,2,...}.{weight,bias}. Loss: likelihood_weight times the negative log
/// likelihood, nats; term "likelihood" without weight.
class DiscreteHead : public BoxHead {
 public:
  /// Throws ConfigError for options out of range.
  DiscreteHead(DiscreteOptions options, HeadContext context);

  std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override;
  HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) override;

 private:
  /// Of each component, (N, usable bins).
  std::vector<at::Tensor> log_probabilities(const HeadInput& input) const;

  DiscreteOptions options_;
  HeadContext context_;
  std::vector<std::shared_ptr<MultilayerPerceptron>> components_;
};

}  // namespace arbox::heads
