#pragma once

#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include "arbox/detectors/pv_rcnn/options.h"

namespace arbox::detectors::pv_rcnn::internal {

/// Scores, residuals and directions of the anchors of each cell.
class AnchorHead : public torch::nn::Module {
 public:
  AnchorHead(const Options& options, std::int64_t in_channels);

  struct Output {
    at::Tensor scores, residuals, directions;  ///< (cells * anchors of a cell, ...)
  };
  /// (cells, in_channels).
  Output forward(const at::Tensor& cells) const;

  std::int64_t anchors_per_cell() const { return anchors_; }

 private:
  std::int64_t anchors_, classes_;
  at::Tensor scores_, scores_bias_, residuals_, residuals_bias_, directions_, directions_bias_;
};

}  // namespace arbox::detectors::pv_rcnn::internal
