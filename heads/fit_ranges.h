#pragma once

#include <cstdint>
#include <span>

#include "arbox/geometry/box.h"
#include "arbox/heads/codec_options.h"
#include "arbox/heads/references.h"

namespace arbox::heads {

/// What bins must reach (paper, section 3.1).
struct RangeGoal {
  /// Least mean IoU of a box with its quantised self.
  double mean_iou = 0.99;
  /// Greatest share of components that may lie outside of their range (not including the end).
  double overflow = 0.001;
};

struct RangeFit {
  /// The codec with its ranges set.
  CodecOptions codec;
  /// Mean IoU of each box with the box of its quantised canonical vector.
  double mean_iou = 0.0;
  /// Share of the components of all boxes that lie outside of their range; angles never do.
  double overflow = 0.0;
  /// Both goals are reached.
  bool reached = false;
};

/// Quality of the ranges that `codec` has.
RangeFit evaluate_ranges(std::span<const geometry::Box> boxes, const References& references,
                         const CodecOptions& codec, const RangeGoal& goal = {});

/// Chooses the ranges of sizes and of centres for boxes relative to their references: the widest
/// that reach both goals, tried from all that occurs (and a hundredth more at each end) down to
/// quantiles that leave just under the allowed share outside, rounded outwards to three digits of
/// their width. If none reaches the IoU, the result has the best of those that keep the overflow,
/// and says so: more bins are needed then. Kind, bins and the rest of `codec` stay as they are.
///
/// references (boxes.size()); float64 is best. Throws InvalidArgument without boxes or with another
/// number of references.
RangeFit fit_ranges(std::span<const geometry::Box> boxes, const References& references,
                    const CodecOptions& codec, const RangeGoal& goal = {});

/// References such as a detector's would be, for fitting ranges to a data set of labels:
///
/// - residual: regions of interest. Each label moved by a normal of 0.1 of its size along its axes,
///   sizes times exp of a normal of 0.1, turned by a normal of 0.1 rad; drawn again until the IoU
///   with the label is at least 0.55, PV-RCNN's bound for regions that learn a box (after 100
///   draws, the label itself).
/// - scaled: s is the largest size times exp of a normal of 0.1, the origin uniform within the
///   middle half of the box, where FCAF3D's locations of highest centreness lie.
/// - quartile: s is uniform between 0.4 and 0.8 of the largest extent along the frame's axes, what
///   the quartiles of points on a box span, the origin moved by a normal of 0.1 s.
///
/// `draws` references for each box: row i serves boxes[i % boxes.size()]. Depends on the seed
/// alone. Throws InvalidArgument for an unknown kind and fewer than one draw.
References simulated_references(std::span<const geometry::Box> boxes, const std::string& kind,
                                int draws, std::uint64_t seed);

}  // namespace arbox::heads
