#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/box.h"

/// \file
/// Non-maximum suppression: of boxes that overlap, the one with the highest score stays.

namespace arbox::geometry {

struct NmsOptions {
  /// A box goes if its IoU with a better one that stayed is above this.
  double threshold = 0.1;
  /// Where IoU is taken: `bev` (yaw-only boxes from above), `3d` (any rotation) or
  /// `axis-aligned` (rotations ignored, volumes).
  std::string space = "bev";
  /// Boxes of different classes never suppress each other.
  bool class_aware = false;
  /// Boxes with a lower score are left out at once; with Soft-NMS also when they sink below it.
  double minimum_score = -std::numeric_limits<double>::infinity();
  /// Only this many boxes of the highest scores take part; 0 means all.
  int pre_limit = 0;
  /// At most this many boxes are kept; 0 means all.
  int post_limit = 0;
  /// Soft-NMS (Bodla et al., ICCV 2017) lowers scores in place of removing boxes. `none`: remove.
  /// `linear`: times 1 - IoU where IoU is above the threshold. `gaussian`: times
  /// exp(-IoU^2 / soft_sigma), whatever the threshold.
  std::string soft = "none";
  double soft_sigma = 0.5;
  /// 0 means default_threads(). The result does not depend on it.
  int threads = 0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "threshold", &NmsOptions::threshold,
        {.help = "IoU above which the box with the lower score goes", .low = 0, .high = 1});
    visitor.field("space", &NmsOptions::space,
                  {.help = "Where boxes meet", .choices = {"bev", "3d", "axis-aligned"}});
    visitor.field("class_aware", &NmsOptions::class_aware,
                  {.help = "Let only boxes of the same class suppress each other"});
    visitor.field("minimum_score", &NmsOptions::minimum_score,
                  {.help = "Boxes with a lower score are left out"});
    visitor.field(
        "pre_limit", &NmsOptions::pre_limit,
        {.help = "Boxes that take part, best first; 0 means all", .unit = "boxes", .low = 0});
    visitor.field("post_limit", &NmsOptions::post_limit,
                  {.help = "Most boxes kept; 0 means all", .unit = "boxes", .low = 0});
    visitor.field("soft", &NmsOptions::soft,
                  {.help = "Soft-NMS: lower the scores of overlapping boxes in place of removing "
                           "them",
                   .choices = {"none", "linear", "gaussian"}});
    visitor.field("soft_sigma", &NmsOptions::soft_sigma,
                  {.help = "Width of the Gaussian of Soft-NMS", .low = 1e-6, .high = 1e6});
    visitor.field("threads", &NmsOptions::threads,
                  {.help = "Threads; 0 means the program's default", .low = 0, .high = 1024});
  }
};

struct NmsResult {
  /// Indices of the boxes that stay, by descending score; of equal scores the lower index first.
  std::vector<std::int64_t> kept;
  /// Their scores, lowered if Soft-NMS was asked for.
  std::vector<double> scores;
};

/// Greedy suppression in the order of descending scores, ties by index: exactly what testing every
/// pair with overlap() gives. No boxes give an empty result.
///
/// `scores` has one finite number a box (at least 0 for Soft-NMS); `classes` one number a box, and
/// is needed for class_aware only. Errors: InvalidArgument, naming the row, for invalid boxes,
/// tilted ones in bird's-eye space, bad scores, wrong lengths and bad options.
/// Cost: O(n log n) and one overlap for each near pair of a box and a kept one; only boxes that
/// share a cell of a grid are looked at.
NmsResult nms(std::span<const Box> boxes, std::span<const double> scores,
              const NmsOptions& options = {}, std::span<const int> classes = {});

}  // namespace arbox::geometry
