#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/overlap.h"

/// \file
/// Average precision of 3-D boxes in rooms, as VoteNet and mmdetection3d compute it for SUN RGB-D
/// and ScanNet: area under the precision-recall curve of a whole data set, with IoU or IoG (Liu et
/// al., ECCV 2022, section 5.2).

namespace arbox::evaluation {

/// A box of a class; the score matters for predictions only.
struct LabeledBox {
  std::string label;
  geometry::Box box;
  double score = 0.0;
};

/// Truth and predictions of one scene, in any common frame.
struct IndoorScene {
  std::string name;
  std::vector<LabeledBox> truth;
  std::vector<LabeledBox> predictions;
};

struct IndoorOptions {
  /// Overlaps that a prediction must exceed; a report holds these and 0.05, 0.10, ..., 0.95.
  std::vector<double> thresholds = {0.25, 0.50};
  /// kIou or kIog; it chooses the best true box too.
  geometry::Overlap overlap = geometry::Overlap::kIou;
  /// Classes to score, in this order; empty means every class of the truth, sorted.
  std::vector<std::string> classes = {};
  /// 0 means default_threads().
  int threads = 0;
};

/// AP and recall at one threshold, percent.
struct IndoorScore {
  double ap = 0.0;
  double recall = 0.0;
};

/// Best precision at each recall that is reached, both in [0, 1], recall rising.
struct PrecisionRecall {
  std::vector<double> recall;
  std::vector<double> precision;
};

struct IndoorClassResult {
  std::string name;
  std::int64_t truth = 0;
  std::int64_t predictions = 0;
  /// One a threshold of the report. A class without truth has no AP and takes no part in the means;
  /// one without predictions has 0.
  std::vector<IndoorScore> scores;
  std::vector<PrecisionRecall> curves;
  /// Mean over 0.05, 0.10, ..., 0.95.
  IndoorScore mean;
};

struct IndoorReport {
  geometry::Overlap overlap = geometry::Overlap::kIou;
  std::int64_t scenes = 0;
  /// Rising; contains the asked for ones and 0.05, 0.10, ..., 0.95.
  std::vector<double> thresholds;
  std::vector<IndoorClassResult> classes;
  /// mAP and mean recall over the classes with truth, one a threshold.
  std::vector<IndoorScore> class_means;
  /// The mean of those over 0.05, 0.10, ..., 0.95.
  IndoorScore mean;
};

/// Scores every class and threshold. Predictions of a class are taken from the highest score down
/// (equal scores in the order of NumPy's argsort over scenes and rows, as in the reference tools);
/// each claims the true box of largest overlap in its scene and is right
/// if that overlap is above the threshold and the box is still free.
///
/// No scenes, or scenes without truth, give a report without AP. The result does not depend on
/// `threads`. Throws InvalidArgument for an invalid box or a score that is not finite (naming scene
/// and row), thresholds outside of [0, 1), classes named twice, and overlap kIntersection.
IndoorReport evaluate_indoor(std::span<const IndoorScene> scenes,
                             const IndoorOptions& options = {});

/// The place of a threshold in the report. Throws InvalidArgument if it is not there.
std::size_t threshold_index(const IndoorReport& report, double threshold);

}  // namespace arbox::evaluation
