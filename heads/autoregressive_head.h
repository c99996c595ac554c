#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/autoregressive_distribution.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/quantizer.h"
#include "arbox/heads/supervision.h"

namespace arbox::heads {

class MultilayerPerceptron;

struct AutoregressiveOptions {
  std::vector<std::int64_t> hidden = {128, 256, 512};
  /// The paper's text sums over components with weight 1; what made its detection tables is the
  /// mean with weight 0.1.
  Reduction reduction = Reduction::kMean;
  double likelihood_weight = 0.1;
  /// Weight of E[1 - IoU(b', y)] (section 3.2.1); needs a codec of upright boxes.
  double iou_weight = 0.0;
  int iou_samples = 1;
  CircularEnds circular_ends = CircularEnds::kMerged;
  int threads = 0;

  /// The paper's box estimator (appendix A).
  static AutoregressiveOptions estimator() {
    AutoregressiveOptions options;
    options.hidden = {128, 256, 512, 1024};
    options.reduction = Reduction::kSum;
    options.likelihood_weight = 1.0;
    return options;
  }

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "hidden", &AutoregressiveOptions::hidden,
        {.help = "Widths of the hidden layers of each component's MLP", .low = 1, .high = 65536});
    visitor.field(
        "reduction", &AutoregressiveOptions::reduction,
        {.help = "How the components' likelihoods are reduced", .choices = {"sum", "mean"}});
    visitor.field("likelihood_weight", &AutoregressiveOptions::likelihood_weight,
                  {.help = "Weight of the likelihood", .low = 0});
    visitor.field("iou_weight", &AutoregressiveOptions::iou_weight,
                  {.help = "Weight of the conditional-expectation IoU; 0 leaves it out", .low = 0});
    visitor.field(
        "iou_samples", &AutoregressiveOptions::iou_samples,
        {.help = "Sampled prefixes of the conditional-expectation IoU", .low = 1, .high = 1024});
    visitor.field("circular_ends", &AutoregressiveOptions::circular_ends,
                  {.help = "The two end bins of an angle: one bin, or two as in imported weights",
                   .choices = {"merged", "distinct"}});
    visitor.field("threads", &AutoregressiveOptions::threads,
                  {.help = "Threads of sampling and search; 0 for the default", .low = 0});
  }
};

/// Predicts a box component by component (paper, section 3.1): one MLP for each, whose inputs are
/// the features, the condition and the de-quantised values of the components before, and whose
/// outputs are the logits of its bins. Parameters: autoreg.{component}.{0,2,...}.{weight,bias}.
///
/// Loss: likelihood_weight times the negative log likelihood with teacher forcing, averaged over
/// the distinct equivalent vectors of the target (section 3.2.2), nats; values outside of a range
/// count as its end bin. With iou_weight, plus iou_weight times the mean over sampled prefixes of
/// 1 - IoU(b', y), b'_i = E[b_i | sampled b_<i, h], circular means for angles; gradient flows
/// through the expectation and the references. Terms: "likelihood", "iou", both without weight.
class AutoregressiveHead : public BoxHead {
 public:
  /// Throws ConfigError for options out of range, and for iou_weight with a codec of boxes that do
  /// not stand upright.
  AutoregressiveHead(AutoregressiveOptions options, HeadContext context);

  std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override;
  HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) override;

  /// p(component | features, values before) as logits: inputs (N, C + E), previous (N, M,
  /// component) -> (N, M, bins), without the last bin where circular ends are merged. The one
  /// definition of the conditionals: losses differentiate it, distributions evaluate the same
  /// parameters through the inference core.
  at::Tensor conditional(std::int64_t component, const at::Tensor& inputs,
                         const at::Tensor& previous) const;

  /// (N, M, D) values on bins -> (N, M): log probability of each vector, with gradient.
  at::Tensor log_probability(const at::Tensor& inputs, const at::Tensor& values) const;

  const AutoregressiveOptions& options() const { return options_; }

 private:
  std::unique_ptr<AutoregressiveDistribution> distribution(const HeadInput& input) const;
  at::Tensor likelihood_loss(const HeadInput& input, const at::Tensor& boxes) const;
  at::Tensor iou_loss(const HeadInput& input, const at::Tensor& boxes) const;

  AutoregressiveOptions options_;
  HeadContext context_;
  std::vector<std::shared_ptr<MultilayerPerceptron>> conditionals_;
  mutable std::mutex model_mutex_;
  mutable std::shared_ptr<const AutoregressiveModel> model_;  // until a parameter is written
};

}  // namespace arbox::heads
