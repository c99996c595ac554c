#pragma once

#include "arbox/heads/box_head.h"

namespace arbox::detectors::pv_rcnn::internal {

/// PV-RCNN's own last step as a head: the one box that the pointwise residuals, which come as the
/// condition, describe. It has no parameters, and its loss is 0: the detector's loss of the
/// residuals trains them.
class PointwiseBranch : public heads::BoxHead {
 public:
  /// Throws ConfigError for a codec that does not describe boxes by residuals to regions.
  explicit PointwiseBranch(heads::HeadContext context);

  std::unique_ptr<heads::BoxDistribution> forward(const heads::HeadInput& input) override;
  heads::HeadLoss loss(const heads::HeadInput& input, const at::Tensor& target_boxes) override;

 private:
  heads::HeadContext context_;
};

}  // namespace arbox::detectors::pv_rcnn::internal
