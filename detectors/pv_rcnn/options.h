#pragma once

#include <optional>

#include "arbox/detectors/pv_rcnn/stage_options.h"
#include "arbox/heads/head_registry.h"

namespace arbox::detectors::pv_rcnn {

/// Balls around points, and the network that sums up what lies in them. No radius: not used.
struct AbstractionOptions {
  std::vector<double> radii;
  std::vector<std::int64_t> samples;
  /// Widths of the layers, the same for each radius.
  std::vector<std::int64_t> widths;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = AbstractionOptions;
    visitor.field("radii", &Self::radii,
                  {.help = "Radii of the balls; none: not used", .unit = "m", .low = 0.01});
    visitor.field(
        "samples", &Self::samples,
        {.help = "Neighbours taken in each ball, one entry a radius", .low = 1, .high = 1024});
    visitor.field("widths", &Self::widths,
                  {.help = "Widths of the layers", .low = 1, .high = 4096});
  }
};

/// Keypoints, and what they gather from points, voxels and the map.
struct KeypointOptions {
  int count = 2048;
  /// `scan`: spread over all points. `proposals`: over the points near proposals (PV-RCNN++).
  std::string around = "scan";
  /// Points are near a proposal up to this far outside of its longest half diagonal.
  double margin = 1.6;
  /// The map seen from above, where it is gathered: `before` or `after` the 2-D backbone, or
  /// `none`.
  std::string birds_eye = "before";
  AbstractionOptions points{{0.4, 0.8}, {16, 16}, {16, 16}};
  AbstractionOptions level1{{0.4, 0.8}, {16, 16}, {16, 16}};
  AbstractionOptions level2{{0.8, 1.2}, {16, 32}, {32, 32}};
  AbstractionOptions level3{{1.2, 2.4}, {16, 32}, {64, 64}};
  AbstractionOptions level4{{2.4, 4.8}, {16, 32}, {64, 64}};
  /// Features of a keypoint after fusion.
  std::int64_t fused = 128;
  /// Hidden layers of the keypoint weighting.
  std::vector<std::int64_t> weighting = {256, 256};

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = KeypointOptions;
    visitor.field("count", &Self::count, {.help = "Keypoints of a scan", .low = 1, .high = 65536});
    visitor.field("around", &Self::around,
                  {.help = "Where keypoints are spread", .choices = {"scan", "proposals"}});
    visitor.field("margin", &Self::margin,
                  {.help = "How far outside of a proposal its keypoints may lie",
                   .unit = "m",
                   .low = 0,
                   .high = 100});
    visitor.field("birds_eye", &Self::birds_eye,
                  {.help = "Gather from the map seen from above, before or after its backbone",
                   .choices = {"none", "before", "after"}});
    visitor.group("points", &Self::points, "What keypoints gather from the points");
    visitor.group("level1", &Self::level1, "From voxels of stride 1");
    visitor.group("level2", &Self::level2, "From voxels of stride 2");
    visitor.group("level3", &Self::level3, "From voxels of stride 4");
    visitor.group("level4", &Self::level4, "From voxels of stride 8");
    visitor.field("fused", &Self::fused,
                  {.help = "Features of a keypoint", .low = 1, .high = 4096});
    visitor.field("weighting", &Self::weighting,
                  {.help = "Hidden layers of the keypoint weighting", .low = 1, .high = 4096});
  }

  /// The levels in order, those that are not used too.
  std::vector<AbstractionOptions> levels() const { return {level1, level2, level3, level4}; }
};

/// The second stage: what is pooled in a region of interest and what follows.
struct RegionOptions {
  /// Grid points along each edge.
  int grid = 6;
  AbstractionOptions pooling{{0.8, 1.6}, {16, 16}, {64, 64}};
  std::vector<std::int64_t> shared = {256, 256}, confidence = {256, 256}, residuals = {256, 256};
  double dropout = 0.3;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = RegionOptions;
    visitor.field("grid", &Self::grid,
                  {.help = "Grid points along each edge of a region", .low = 1, .high = 32});
    visitor.group("pooling", &Self::pooling, "What a grid point gathers from keypoints");
    visitor.field("shared", &Self::shared,
                  {.help = "Shared layers; the last one's width is what the head gets",
                   .low = 1,
                   .high = 65536});
    visitor.field("confidence", &Self::confidence,
                  {.help = "Hidden layers of the confidence", .low = 1, .high = 65536});
    visitor.field("residuals", &Self::residuals,
                  {.help = "Hidden layers of the pointwise residuals", .low = 1, .high = 65536});
    visitor.field("dropout", &Self::dropout,
                  {.help = "Share of features left out in training", .low = 0, .high = 0.95});
  }
};

/// From regions of interest to detections.
struct PostOptions {
  /// Detections below this score are left out.
  double score = 0.1;
  /// Metres, seen from above, that a region's pointwise box must keep from the sensor, or it is
  /// left out before suppression: what is so near is the vehicle that carries the sensor. 0:
  /// nothing is.
  double clearance = 0;
  double nms_iou = 0.1;
  int nms_candidates = 4096, detections = 500;
  bool nms_class_aware = false;
  /// Which boxes suppression compares: those of the pointwise branch, so that the head works on the
  /// survivors alone, or those that are decoded from the head's distribution.
  std::string nms_on = "pointwise";
  /// Which of the network's heads answers: Options::head if empty, else one of
  /// Options::more_heads.
  std::string head = {};
  /// The box of a detection: the distribution's `mode` (beam search), `mean`, a `quantile` box, or
  /// that of the `pointwise` branch.
  std::string box = "mode";
  int beam_width = 16;
  /// Bins: what the mode is searched in is smoothed with a kernel of this standard deviation
  /// (heads::ModeOptions). 0: the most likely bins.
  double mode_smoothing = 0;
  double quantile = 0.2;
  /// What DetectionRequest::known_sizes are compared by: `joint`, how likely the size is and the
  /// box of it, or `given_size`, the box alone (ConditioningOptions::score).
  std::string known_sizes = "joint";
  /// Draws for quantile boxes and uncertainty.
  int samples = 64;
  /// The score of a detection: its `confidence`, or, `overlap`, that times the share of the draws
  /// whose IoU with the detection's box is at least `overlap_iou`, how likely the box is to be a
  /// good one. Suppression of pointwise boxes goes by the confidence.
  std::string scoring = "confidence";
  double overlap_iou = 0.5;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = PostOptions;
    visitor.field("score", &Self::score,
                  {.help = "Detections below this score are left out", .low = 0, .high = 1});
    visitor.field("clearance", &Self::clearance,
                  {.help = "Boxes that come nearer to the sensor, seen from above, are left out as "
                           "the own vehicle; 0: none",
                   .unit = "m",
                   .low = 0,
                   .high = 100});
    visitor.field("nms_iou", &Self::nms_iou,
                  {.help = "Of two detections that overlap more than this from above the better "
                           "one stays",
                   .low = 0,
                   .high = 1});
    visitor.field("nms_candidates", &Self::nms_candidates,
                  {.help = "Boxes that take part in suppression", .low = 1});
    visitor.field("detections", &Self::detections, {.help = "Detections of a scan", .low = 1});
    visitor.field("nms_class_aware", &Self::nms_class_aware,
                  {.help = "Let only boxes of the same class suppress each other"});
    visitor.field(
        "nms_on", &Self::nms_on,
        {.help = "Which boxes suppression compares", .choices = {"pointwise", "decoded"}});
    visitor.field("head", &Self::head,
                  {.help = "Which of the network's heads answers; empty: its first"});
    visitor.field(
        "box", &Self::box,
        {.help = "The box of a detection", .choices = {"mode", "mean", "quantile", "pointwise"}});
    visitor.field("beam_width", &Self::beam_width,
                  {.help = "Beams of the search for the mode", .low = 1, .high = 4096});
    visitor.field("mode_smoothing", &Self::mode_smoothing,
                  {.help = "Standard deviation of the kernel that densities are smoothed with "
                           "before the search for the mode",
                   .unit = "bins",
                   .low = 0,
                   .high = 1000});
    visitor.field("quantile", &Self::quantile,
                  {.help = "q of the box where box is quantile", .low = 0.001, .high = 0.999});
    visitor.field(
        "known_sizes", &Self::known_sizes,
        {.help = "Density that known sizes are compared by", .choices = {"joint", "given_size"}});
    visitor.field("samples", &Self::samples,
                  {.help = "Draws for quantile boxes and uncertainty", .low = 1, .high = 100000});
    visitor.field("scoring", &Self::scoring,
                  {.help = "The score of a detection: its confidence, or that times the share of "
                           "the draws that overlap the box",
                   .choices = {"confidence", "overlap"}});
    visitor.field("overlap_iou", &Self::overlap_iou,
                  {.help = "IoU from which a draw overlaps the box", .low = 0, .high = 1});
  }
};

/// A whole PV-RCNN (Shi et al., CVPR 2020). Defaults: the published KITTI network, pointwise head.
struct Options {
  std::vector<std::string> classes = {"Car", "Pedestrian", "Cyclist"};
  /// The sensor's height above the ground that the network knows, and that of the sensor in use if
  /// it differs: clouds are shifted so that the ground is where the network expects it.
  double trained_sensor_height = 1.73;
  std::optional<double> sensor_height = {};
  VoxelOptions voxels;
  BackboneOptions backbone;
  BirdsEyeOptions birds_eye;
  /// How much of their batch norms' running statistics a new batch replaces: after a run of n steps
  /// (1 - momentum)^n of the initial ones is left, so short runs need more than the default.
  double backbone_norm_momentum = 0.01;
  AnchorOptions anchors;
  ProposalOptions proposals;
  ProposalOptions training_proposals = ProposalOptions::training();
  KeypointOptions keypoints;
  RegionOptions regions;
  heads::HeadConfig head = {.name = "pointwise", .options = {}, .codec = {}};
  /// Further heads beside it, on the same features and with the same codec. PostOptions::head
  /// chooses the one that answers.
  std::vector<std::string> more_heads = {};
  /// Changes to their options, each NAME.KEY=VALUE.
  std::vector<std::string> more_head_options = {};
  PostOptions post;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("classes", &Options::classes, {.help = "Names of the classes"});
    visitor.field("trained_sensor_height", &Options::trained_sensor_height,
                  {.help = "Height of the sensor above the ground in the training scans",
                   .unit = "m",
                   .low = -100,
                   .high = 100});
    visitor.field(
        "sensor_height", &Options::sensor_height,
        {.help = "Height of the sensor in use, if another", .unit = "m", .low = -100, .high = 100});
    visitor.group("voxels", &Options::voxels, "Range and voxels");
    visitor.group("backbone", &Options::backbone, "Sparse 3-D backbone");
    visitor.group("birds_eye", &Options::birds_eye, "2-D backbone over the map from above");
    visitor.field("backbone_norm_momentum", &Options::backbone_norm_momentum,
                  {.help = "How much of the running statistics of the backbones' batch norms a new "
                           "batch replaces",
                   .low = 0,
                   .high = 1});
    visitor.group("anchors", &Options::anchors, "Boxes that the first stage starts from");
    visitor.group("proposals", &Options::proposals, "Regions of interest in detection");
    visitor.group("training_proposals", &Options::training_proposals,
                  "Regions of interest in training");
    visitor.group("keypoints", &Options::keypoints, "Keypoints and what they gather");
    visitor.group("regions", &Options::regions, "The second stage");
    visitor.group("head", &Options::head, "The last step: a distribution over boxes");
    visitor.field("more_heads", &Options::more_heads,
                  {.help = "Further heads beside it, on the same features"});
    visitor.field("more_head_options", &Options::more_head_options,
                  {.help = "Changes to their options, each NAME.KEY=VALUE"});
    visitor.group("post", &Options::post, "From regions of interest to detections");
  }
};

/// Throws ConfigError that begins with `where` and lists every violation: values out of range,
/// lists whose lengths do not agree, a range that is no whole number of voxels or empty, a head
/// that is named twice, options and choices of heads that are not there.
void require_valid(const Options& options, const std::string& where);

}  // namespace arbox::detectors::pv_rcnn
