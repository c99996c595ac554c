#pragma once

#include <memory>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/point_loss.h"
#include "arbox/heads/supervision.h"

namespace arbox::heads {

class MultilayerPerceptron;

struct PointwiseOptions {
  std::vector<std::int64_t> hidden = {128, 256, 512};
  PointLoss loss = PointLoss::kL1;
  double beta = 1.0 / 9.0;
  Supervision supervision = Supervision::kNearest;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("hidden", &PointwiseOptions::hidden,
                  {.help = "Widths of the hidden layers", .low = 1, .high = 65536});
    visitor.field("loss", &PointwiseOptions::loss,
                  {.help = "Loss of a component", .choices = {"l1", "smooth_l1"}});
    visitor.field("beta", &PointwiseOptions::beta,
                  {.help = "Where smooth_l1 turns linear, in half ranges", .low = 1e-9});
    visitor.field("supervision", &PointwiseOptions::supervision,
                  {.help = "Supervised vectors where a box has several",
                   .choices = {"canonical", "nearest", "all"}});
  }
};

/// Predicts one vector of the codec's components, all at once (the L1 baseline of the paper,
/// section 5). An MLP gives each component over half of its range, from the middle of the range.
/// Parameters: layers.{0,2,...}.{weight,bias}. Loss: mean over the components of the differences in
/// half ranges, wrapped for angles. Its distribution is a PointDistribution.
class PointwiseHead : public BoxHead {
 public:
  /// Throws ConfigError for options out of range.
  PointwiseHead(PointwiseOptions options, HeadContext context);

  std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override;
  HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) override;

 private:
  at::Tensor components(const HeadInput& input) const;

  PointwiseOptions options_;
  HeadContext context_;
  std::shared_ptr<MultilayerPerceptron> layers_;
};

}  // namespace arbox::heads
