#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <span>
#include <string>

#include "arbox/base/option_field.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/training/pv_rcnn/anchor_targets.h"
#include "arbox/training/pv_rcnn/proposal_targets.h"

/// \file
/// PV-RCNN's losses (Shi et al., CVPR 2020, section 3.4; constants as in OpenPCDet). Everything
/// works in float and double, has gradients to the network's outputs, and gives 0 with a graph
/// behind it for scans without objects, positives or proposals.

namespace arbox::training::pv_rcnn {

struct LossOptions {
  /// Weights in the total. Sums are over scans for the first three, which are divided by each
  /// scan's positives and the number of scans; over keypoints, proposals or foreground for the
  /// rest, which are divided by their number in the whole batch.
  double classification = 1.0, box = 2.0, direction = 0.2;
  double keypoint = 1.0;
  double confidence = 1.0, residual = 1.0, corner = 1.0;
  double head = 1.0;
  double focal_alpha = 0.25, focal_gamma = 2.0;
  /// Where smooth L1 turns linear.
  double beta = 1.0 / 9.0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = LossOptions;
    const auto weight = [&](std::string_view name, double Self::*member, std::string_view help) {
      visitor.field(name, member, {.help = help, .low = 0.0, .high = 1e6});
    };
    weight("classification", &Self::classification, "Weight of the anchors' classes");
    weight("box", &Self::box, "Weight of the anchors' boxes");
    weight("direction", &Self::direction, "Weight of the anchors' directions");
    weight("keypoint", &Self::keypoint, "Weight of the keypoints' foreground");
    weight("confidence", &Self::confidence, "Weight of the proposals' confidence");
    weight("residual", &Self::residual, "Weight of the pointwise residuals");
    weight("corner", &Self::corner, "Weight of the pointwise boxes' corners");
    weight("head", &Self::head, "Weight of each head's own loss");
    visitor.field("focal_alpha", &Self::focal_alpha,
                  {.help = "Focal loss: weight of positives", .low = 0, .high = 1});
    visitor.field("focal_gamma", &Self::focal_gamma,
                  {.help = "Focal loss: exponent", .low = 0, .high = 10});
    visitor.field("beta", &Self::beta,
                  {.help = "Where smooth L1 turns linear", .low = 1e-6, .high = 100});
  }
};

/// Focal loss (Lin et al., ICCV 2017) of logits against targets in [0, 1], elementwise.
at::Tensor focal_loss(const at::Tensor& logits, const at::Tensor& targets,
                      const LossOptions& options);

/// Smooth L1 of residuals (P, 7) against targets (P, 7): (P, 7). The last column compares sines:
/// sin(yaw - target), so that a box turned by half costs nothing.
at::Tensor anchor_box_loss(const at::Tensor& residuals, const at::Tensor& targets, double beta);

/// (F) of boxes (F, 7) against targets (F, 7): mean over the eight corners of Huber's loss (beta 1)
/// of the distance to the target's corner, or to that of the target turned by half, if nearer.
at::Tensor corner_loss(const at::Tensor& boxes, const at::Tensor& targets);

/// Scalars with gradient, by name.
using LossSums = std::map<std::string, at::Tensor>;

/// Sums over the scans of "classification", "box" and "direction", each scan's divided by its
/// number of positive candidates (at least 1). anchors (A, 7).
LossSums first_stage_losses(const detectors::pv_rcnn::FirstStage& first, const at::Tensor& anchors,
                            std::span<const AnchorTargets> targets, const SceneObjects& objects,
                            double direction_offset, const LossOptions& options);

/// "confidence": sum over the proposals whose target is not ignored; "residual" and "corner": sums
/// over the foreground.
LossSums second_stage_losses(const detectors::pv_rcnn::SecondStage& second,
                             const ProposalTargets& targets, const LossOptions& options);

/// Sum over the keypoints that are not ignored (targets (K), see keypoint_targets).
at::Tensor keypoint_loss(const at::Tensor& logits, const at::Tensor& targets,
                         const LossOptions& options);

}  // namespace arbox::training::pv_rcnn
