#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arbox/evaluation/containment.h"
#include "arbox/geometry/detection.h"

/// \file
/// Whether a detector knows how sure it may be (Liu et al., ECCV 2022, sections 5.2 and 5.3): how
/// often its boxes contain what they promise to contain, and whether its uncertainty tells good
/// boxes from bad ones. Only objects that were found count; how many are found is for the protocols
/// of average precision (kitti_protocol.h) and recall.h.

namespace arbox::evaluation {

/// Detections of one scan and its labelled objects, in one frame.
struct UncertaintyScan {
  /// With quantile boxes, confidence boxes and uncertainty, as far as the detector gives them.
  std::vector<geometry::Detection> detections;
  std::vector<geometry::Detection> objects;
};

struct UncertaintyOptions {
  /// Classes to be scored; empty: all of the objects.
  std::vector<std::string> classes = {};
  /// Detections with a lower score are left out.
  double min_score = 0.0;
  /// How far a detection's centre may be from its object's (center_matching.h), metres.
  double max_distance = 2.0;
  /// The share of the true box that counts as containing it.
  double min_iog = kContainedIog;
  /// Confidence boxes at these p are made from the detections' samples and scored beside those that
  /// they bring: what their distributions promise before any calibration.
  std::vector<double> sample_confidences = {};
  /// The detections' samples promise how often their boxes overlap the object by these IoU.
  std::vector<double> promised_ious = {0.25, 0.5, 0.7};
  /// Boxes with an IoU below this are wrong; the uncertainty should tell which (paper, section
  /// 5.3).
  double wrong_iou = 0.25;
};

/// What the samples say of a ranking: each box is wrong with the share of its detection's samples
/// that overlap it by less than wrong_iou. Where that chance is true, no ranking can tell wrong
/// boxes better than the chance itself. Few samples make chances look more decisive than they are:
/// of street scans, 64 expect a ROC AUC of the chance that is 0.01 higher than what 512 expect.
struct ExpectedRanking {
  /// How many boxes are wrong.
  double wrong = 0.0;
  /// ROC AUC (expected_roc_auc()) of the uncertainty, and of the chance itself.
  std::optional<double> roc_auc, chance_roc_auc;
};

/// Boxes and what the uncertainty of their detections tells of them.
struct RankedBoxes {
  /// Objects that have such a box, and how many of these boxes are wrong.
  std::size_t boxes = 0, wrong = 0;
  /// Over the boxes; 0 without any.
  double mean_iou = 0.0;
  /// Over the boxes whose detection has an uncertainty: area under the ROC curve of telling wrong
  /// boxes, and rank correlation with the IoU (the nearer to -1 the better). Empty where they are
  /// not defined, such as without a wrong box.
  std::optional<double> roc_auc, spearman;
  /// Over the same boxes, if all their detections have samples: ROC AUC of the samples' chance that
  /// a box is wrong, and what the samples expect of both rankings.
  std::optional<double> chance_roc_auc;
  std::optional<ExpectedRanking> expected;
};

/// Promise and fact of all boxes of one kind, for example all quantile boxes of q = 0.2. The paper
/// ranks quantile boxes: its table of uncertainty measures has ROC AUC and rank correlation of
/// U(0.2, 0.8) with the boxes of q = 0.2, 0.5 and 0.8 as the prediction (section 5.3).
struct BoxLevel : RankedBoxes {
  /// q of quantile boxes, p of confidence boxes.
  double level = 0.0;
  /// 1 - q or p.
  double promised = 0.0;
  /// Share of the boxes whose IoG is above min_iog.
  double contained = 0.0;
  /// Mean share of a detection's samples that its box contains likewise: what the distribution
  /// itself promises of such boxes, ordered or not. A quantile box of q holds 1 - q of an ordered
  /// one only (theorem 1). Empty unless every such detection has samples.
  std::optional<double> held = {};
};

/// How often the detections' own boxes overlap their objects, and how often the samples say so.
struct PromisedOverlap {
  double iou = 0.0;
  /// Mean over the boxes of the share of the samples that overlap the box by that IoU or more
  /// (geometry::overlapping_share).
  double promised = 0.0;
  /// Share of the boxes that overlap their object so.
  double kept = 0.0;
  /// Found objects whose detection has samples.
  std::size_t boxes = 0;
};

/// An object that was found.
struct FoundBox {
  std::string label;
  double iou = 0.0, iog = 0.0;
  std::optional<double> uncertainty = {};
};

struct UncertaintyFigures {
  /// A class, or "all".
  std::string label;
  std::size_t objects = 0;
  /// Objects that were found, and the detections' own boxes of them.
  RankedBoxes found;
  /// Over the found objects; 0 where there are none. F1 = 2 IoU IoG / (IoU + IoG), of the means and
  /// averaged over the objects.
  double mean_iog = 0.0, f1_of_means = 0.0, mean_f1 = 0.0;
  /// By level, rising.
  std::vector<BoxLevel> quantile_boxes, sample_boxes, confidence_boxes;
  /// By IoU, as in the options; empty without samples.
  std::vector<PromisedOverlap> overlaps;
};

struct UncertaintyReport {
  UncertaintyOptions options;
  std::size_t scans = 0;
  /// In the order of the options, or of their names.
  std::vector<UncertaintyFigures> classes;
  UncertaintyFigures all;
  /// All found objects, scan by scan.
  std::vector<FoundBox> found;
};

/// Matches the detections of every scan with its objects by class and centre, and scores the
/// matched ones. No scans give a report of zeros. Throws InvalidArgument for options out of range,
/// invalid boxes and uncertainties that are not finite. Cost: detections times objects of each
/// scan.
UncertaintyReport evaluate_uncertainty(std::span<const UncertaintyScan> scans,
                                       const UncertaintyOptions& options = {});

/// G, the deviation of the sampled sizes (geometry::gaussian_uncertainty), in place of each
/// detection's own uncertainty: the measure that the paper compares with. Throws InvalidArgument
/// for a detection without samples.
void use_gaussian_uncertainty(std::span<geometry::Detection> detections);

/// Wilson's interval (1927) of a share at 95 %: {low, high} for `hits` among `trials`; {0, 1} for
/// no trials.
struct ShareInterval {
  double low = 0.0, high = 1.0;
};
ShareInterval share_interval(std::size_t hits, std::size_t trials);

/// {"protocol": "uncertainty", "scans": 2, "min_iog": 0.95, "wrong_iou": 0.25, "max_distance": 2.0,
///  "min_score": 0.3, "classes": {"Car": {"objects": 9, "found": 8, "wrong": 1, "mean_iou": ...,
///  "mean_iog": ..., "f1_of_means": ..., "mean_f1": ..., "roc_auc": ..., "spearman": ...,
///  "chance_roc_auc": ..., "expected": {"wrong": 0.9, "roc_auc": ..., "chance_roc_auc": ...},
///  "quantile_boxes": [{"q": 0.1, "promised": 0.9, "contained": 0.88, "held": 0.89, "boxes": 8,
///  "wrong": 1, "mean_iou": ..., "roc_auc": ..., "spearman": ..., "chance_roc_auc": ...,
///  "expected": {...}}], "sample_boxes": [{"p": 0.9, ...}], "confidence_boxes": [{"p": 0.9, ...}],
///  "overlaps": [{"iou": 0.5, "promised": 0.96, "kept": 0.95, "boxes": 8}]}},
///  "all": {...}}; figures that are not defined are null.
std::string to_json(const UncertaintyReport& report);

/// Lines for a terminal.
std::string to_table(const UncertaintyReport& report);

}  // namespace arbox::evaluation
