#include "arbox/detectors/pv_rcnn/internal/anchor_head.h"

#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/full.h>
#include <ATen/ops/linear.h>

#include <cmath>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/row_layer.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

constexpr std::int64_t kDirections = 2;
// What an anchor is believed to be before anything is learnt: 1 % of them are objects.
constexpr double kFirstBelief = 0.01;
constexpr double kResidualSpread = 0.001;

}  // namespace

AnchorHead::AnchorHead(const Options& options, std::int64_t in_channels)
    : anchors_(
          static_cast<std::int64_t>(options.classes.size() * options.anchors.rotations.size())),
      classes_(static_cast<std::int64_t>(options.classes.size())) {
  const auto add = [&](const char* name, std::int64_t numbers, at::Tensor& weight,
                       at::Tensor& bias) {
    const auto layer = add_child(*this, name);
    const std::int64_t out = anchors_ * numbers;
    weight =
        layer->register_parameter("weight", initial_weight({out, in_channels, 1, 1}, in_channels));
    bias = layer->register_parameter("bias", initial_weight({out}, in_channels));
  };
  add("conv_cls", classes_, scores_, scores_bias_);
  add("conv_box", kBoxNumbers, residuals_, residuals_bias_);
  add("conv_dir_cls", kDirections, directions_, directions_bias_);
  scores_bias_.detach().fill_(-std::log((1 - kFirstBelief) / kFirstBelief));
  residuals_.detach().normal_(0, kResidualSpread);
}

AnchorHead::Output AnchorHead::forward(const at::Tensor& cells) const {
  const at::Tensor weight = at::cat({scores_, residuals_, directions_}).flatten(1);
  const at::Tensor bias = at::cat({scores_bias_, residuals_bias_, directions_bias_});
  const at::Tensor all = at::linear(cells, weight, bias);
  const std::int64_t first = anchors_ * classes_, second = first + anchors_ * kBoxNumbers;
  return {all.slice(1, 0, first).reshape({-1, classes_}),
          all.slice(1, first, second).reshape({-1, kBoxNumbers}),
          all.slice(1, second).reshape({-1, kDirections})};
}

}  // namespace arbox::detectors::pv_rcnn::internal
