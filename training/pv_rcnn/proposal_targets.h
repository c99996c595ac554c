#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/training/scene.h"

namespace arbox::training::pv_rcnn {

/// The objects of each scan of a batch.
using SceneObjects = std::vector<std::vector<SceneObject>>;

/// Which proposals a second stage learns from, and what they shall say (PV-RCNN, section 3.4).
struct ProposalTargetOptions {
  /// Proposals of a scan, and the share of them that are foreground if there are enough.
  int count = 128;
  double foreground_share = 0.5;
  /// IoU with an object of the proposal's class from which it is foreground: its box is learned.
  double foreground_iou = 0.55;
  /// Background below this is easy, the rest hard; share of the background that is hard.
  double hard_iou = 0.1, hard_share = 0.8;
  /// Confidence: 0 up to the first IoU, 1 from the second, a line between.
  double confidence_low = 0.25, confidence_high = 0.75;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = ProposalTargetOptions;
    const auto share = [&](std::string_view name, double Self::*member, std::string_view help) {
      visitor.field(name, member, {.help = help, .low = 0.0, .high = 1.0});
    };
    visitor.field("count", &Self::count,
                  {.help = "Proposals of a scan that are learned from", .low = 1, .high = 65536});
    share("foreground_share", &Self::foreground_share, "Share of them that are foreground");
    share("foreground_iou", &Self::foreground_iou, "IoU from which a proposal is foreground");
    share("hard_iou", &Self::hard_iou, "IoU from which background is hard");
    share("hard_share", &Self::hard_share, "Share of the background that is hard");
    share("confidence_low", &Self::confidence_low, "IoU up to which the confidence is 0");
    share("confidence_high", &Self::confidence_high, "IoU from which the confidence is 1");
  }
};

/// Proposals that were drawn, scan by scan, and their targets.
struct ProposalTargets {
  at::Tensor boxes;       ///< (S, 7) the regions.
  at::Tensor labels;      ///< (S) int64 class.
  at::Tensor scene;       ///< (S) int64 scan of the batch, never falling.
  at::Tensor iou;         ///< (S) with the best object of the class, 0 without one.
  at::Tensor confidence;  ///< (S) in [0, 1], or -1: ignored.
  at::Tensor foreground;  ///< (F) int64 rows whose box is learned: iou from foreground_iou on.
  at::Tensor objects;     ///< (F, 7) the box that each of them shall find.
};

/// Draws proposals of each scan. Foreground is drawn without replacement, background with; if a
/// scan has only one of the two, that fills the count (with replacement). A scan without proposals
/// gives none. IoUs are exact, in 3-D. With ignore_similar the confidence of a proposal that is not
/// foreground is ignored if its IoU with an other object that resembles its class is above
/// confidence_low. Draws of scan i depend on (seed, first_scene + i).
///
/// Throws ConfigError for options out of range or confidence_low not below confidence_high,
/// InvalidArgument if a proposal names a scan without objects' entry.
ProposalTargets draw_proposals(const detectors::pv_rcnn::Proposals& proposals,
                               const SceneObjects& objects, const ProposalTargetOptions& options,
                               bool ignore_similar, std::uint64_t seed, std::int64_t first_scene);

/// Proposals that overlap an object.
struct MatchedProposals {
  at::Tensor rows;     ///< (F) int64 rows of the proposals, rising.
  at::Tensor objects;  ///< (F, 7) the box of the object of its class that each overlaps most.
};

/// Every proposal with an IoU of at least `least_iou` with an object of its class. Throws
/// InvalidArgument as draw_proposals does.
MatchedProposals match_proposals(const detectors::pv_rcnn::Proposals& proposals,
                                 const SceneObjects& objects, double least_iou);

/// boxes (F, 7) with their headings turned by half a turn where that brings them within a right
/// angle of the regions' (F, 7) headings: the box that a region in its own direction can find.
at::Tensor aligned_boxes(const at::Tensor& boxes, const at::Tensor& regions);

/// What keypoints shall say: 1 inside of an object, -1 (ignored) within `ring` / 2 metres outside
/// of one, 0 elsewhere; with ignore_similar also -1 inside of objects that resemble a class. points
/// (K, 3), scan by scan as `counts` says; gives (K) float.
at::Tensor keypoint_targets(const at::Tensor& points, std::span<const std::int64_t> counts,
                            const SceneObjects& objects, double ring, bool ignore_similar);

}  // namespace arbox::training::pv_rcnn
