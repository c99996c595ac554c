#include "arbox/detectors/pv_rcnn/internal/pointwise_branch.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>

#include "arbox/base/error.h"
#include "arbox/heads/point_distribution.h"
#include "arbox/heads/yaw_codecs.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

constexpr const char* kName = "pointwise branch";

}  // namespace

PointwiseBranch::PointwiseBranch(heads::HeadContext context) : context_(std::move(context)) {
  if (dynamic_cast<const heads::ResidualCodec*>(context_.codec.get()) == nullptr) {
    throw ConfigError("head pointwise: expected codec.kind residual");
  }
}

std::unique_ptr<heads::BoxDistribution> PointwiseBranch::forward(const heads::HeadInput& input) {
  input.require_valid(context_, kName);
  const at::Tensor& residuals = input.condition;
  const bool size_first = context_.codec->size_components().front() == 0;
  const at::Tensor center = residuals.slice(1, 0, 3), size = residuals.slice(1, 3, 6);
  return std::make_unique<heads::PointDistribution>(
      at::cat({size_first ? size : center, size_first ? center : size, residuals.slice(1, 6, 7)},
              1),
      context_.codec, input.references);
}

heads::HeadLoss PointwiseBranch::loss(const heads::HeadInput& input,
                                      const at::Tensor& target_boxes) {
  input.require_valid(context_, kName);
  heads::require_targets(target_boxes, input.count(), kName);
  return {input.condition.sum(1) * 0, {}};
}

}  // namespace arbox::detectors::pv_rcnn::internal
